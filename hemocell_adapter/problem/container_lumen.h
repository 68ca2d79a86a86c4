// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Lumens that `<container>` describes.
#pragma once

#include "hemocell_adapter/problem/job.h"
#include "hemocell_adapter/problem/lumen.h"

namespace packmesh::hemocell {

/// The body of `<container>`, or the box of the case, less the obstacles.
Lumen containerLumen(const Job& job);

}  // namespace packmesh::hemocell
