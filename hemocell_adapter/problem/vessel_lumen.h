// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Lumens of cases with an STL.
#pragma once

#include "hemocell_adapter/problem/job.h"
#include "hemocell_adapter/problem/lumen.h"

namespace packmesh::hemocell {

/// A case with an STL: the vessel as HemoCell places it, open along x.
Lumen vesselLumen(const Job& job);

}  // namespace packmesh::hemocell
