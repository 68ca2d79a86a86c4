// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Whether a single cell fits into a container at all.
#pragma once

#include <string>

#include "packMesh/container/container.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// Refuses a cell that cannot be in the container in any orientation because it would intersect the wall or
/// its own periodic image, provided that this can be proved.
///
/// The space of orientations is divided until in each part one cause holds for all of them: the cell is wider
/// than the container along some direction, or two balls in it, one of them translated by periods, overlap.
/// Gives up at the first orientation without a cause, and after about a second; then nothing is refused.
/// @param name of the species
/// @param wallClearance, clearance to the wall, and of a cell to its images [µm]
/// @throws InputError
void requireFitsAlone(const std::string& name, const Shape& shape, const Container& container,
                      double wallClearance, double clearance);

}  // namespace packmesh
