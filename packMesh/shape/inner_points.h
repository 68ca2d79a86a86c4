// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Points in a shape that stand for its volume.
#pragma once

#include <vector>

#include "packMesh/shape/shape.h"

namespace packmesh {

/// So many points spread evenly (Halton's) in a shape's surface, in its body frame [µm]; fewer in a shape
/// that fills less than a thousandth of its box, at least one. The first n of them are innerPoints(shape, n).
std::vector<Vec3> innerPoints(const Shape& shape, int count);

}  // namespace packmesh
