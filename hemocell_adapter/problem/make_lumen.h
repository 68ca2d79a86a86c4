// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Builds the lumen of a request.
#pragma once

#include "hemocell_adapter/problem/lumen.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

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
