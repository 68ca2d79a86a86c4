// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HemoCell's acceptance in a lumen that repeats.
#pragma once

#include <memory>

#include "hemocell_adapter/hemocell/acceptance.h"

namespace packmesh::hemocell {

/// As makeAcceptedWall, but along axes where `container` is periodic the lattice repeats: there the faces of
/// the lattice are no wall, and only the flags of the (repeated) nodes count. Owns what it needs.
/// @param reach how far a vertex can lie outside the period [µm]
std::shared_ptr<const Wall> makePeriodicAcceptedWall(std::shared_ptr<const Container> container,
                                                     std::shared_ptr<const Lattice> lattice,
                                                     int minimumDistanceFromSolid, double reach,
                                                     double wallClearance);

}  // namespace packmesh::hemocell
