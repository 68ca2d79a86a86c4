// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Points that represent the volume of a shape.
#pragma once

#include <vector>

#include "packMesh/shape/shape.h"

namespace packmesh {

/// `count` evenly spread points (Halton sequence) inside a shape, in its body frame [µm]; fewer, but at least
/// one, if the shape fills less than a thousandth of its bounding box. The first n points are
/// innerPoints(shape, n).
std::vector<Vec3> innerPoints(const Shape& shape, int count);

}  // namespace packmesh
