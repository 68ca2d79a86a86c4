// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Lumens of cases with an STL.
#pragma once

#include "hemocell_adapter/problem/lumen.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

/// A case with an STL: the vessel as HemoCell places it, open along x.
Lumen vesselLumen(const Request& request, const Case& simulation,
                  const std::optional<PreInletPlace>& preInlet);

}  // namespace packmesh::hemocell
