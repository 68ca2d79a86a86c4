// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Builds the lumen of a request.
#pragma once

#include <optional>
#include <string>

#include "hemocell_adapter/problem/lumen.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

/// A warning about a wall without a solid node: HemoCell does not see it. Empty if there is none, or no
/// lattice.
std::optional<std::string> unseenWallWarning(const Lumen& lumen);

/// The body of `<container>`, or the box of the case, less the obstacles.
Lumen containerLumen(const Request& request, const Case* simulation);

/// A case with an STL: the vessel as HemoCell places it, open along x.
Lumen vesselLumen(const Request& request, const Case& simulation,
                  const std::optional<PreInletPlace>& preInlet);

/// Builds the lumen of a request, and the case it is for (nullptr: none), for packing and checking alike.
///
/// The ends of a case's lumen are closed unless the request specifies otherwise, although HemoCell's flow is
/// periodic: the cells it keeps do not cross them, so that none of those can overlap the image of another
/// one.
/// @throws InputError, MeshError
Lumen makeLumen(const Request& request, const Case* simulation, const std::optional<PreInletPlace>& preInlet);

/// The wall for packing one species; nullptr: the container's own.
std::shared_ptr<const Wall> speciesWall(const Lumen& lumen, int minimumDistanceFromSolid, double reach,
                                        double wallClearance);

}  // namespace packmesh::hemocell
