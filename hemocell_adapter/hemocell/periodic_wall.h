// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HemoCell's acceptance rules in a periodic lumen.
#pragma once

#include <memory>

#include "hemocell_adapter/hemocell/acceptance.h"

namespace packmesh::hemocell {

/// Like makeAcceptedWall, but the lattice repeats along axes where `container` is periodic: there the faces
/// of the lattice are not walls, and only the flags of the (repeated) nodes count. Owns its data.
/// @param reach largest distance of a vertex outside the period [µm]
std::shared_ptr<const Wall> makePeriodicAcceptedWall(std::shared_ptr<const Container> container,
                                                     std::shared_ptr<const Lattice> lattice,
                                                     int minimumDistanceFromSolid, double reach,
                                                     double wallClearance);

}  // namespace packmesh::hemocell
