// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Lumens that `<container>` describes.
#pragma once

#include "hemocell_adapter/problem/lumen.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

/// The body of `<container>`, or the box of the case, less the obstacles.
Lumen containerLumen(const Request& request, const Case* simulation);

}  // namespace packmesh::hemocell
