// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Whether a single cell can be in a container at all.
#pragma once

#include <string>

#include "packMesh/container/container.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// Refuses a cell that cannot be in the container in any orientation, because it would meet the wall or its
/// own periodic image, where that can be proved.
///
/// Orientations are divided until in each part of them one cause holds for all: the cell is wider than the
/// container along some direction, or two balls in it, one of them moved by periods, meet. Gives up at the
/// first orientation without a cause, and after about a second: then nothing is refused.
/// @param name of the species
/// @param wallClearance, clearance to the wall, and of a cell to its images [µm]
/// @throws InputError
void requireFitsAlone(const std::string& name, const Shape& shape, const Container& container,
                      double wallClearance, double clearance);

}  // namespace packmesh
