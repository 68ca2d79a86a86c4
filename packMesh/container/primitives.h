// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Containers with a closed form: boxes, cylinders, spheres.
///
/// distance() is the distance to the nearest wall (outside an edge between two walls it is smaller than the
/// true distance). examine() tests vertices, since the lumens are convex. Touching counts as meeting. The
/// surface() of a cylinder or sphere circumscribes it, so it contains the lumen.
#pragma once

#include <array>
#include <memory>

#include "packMesh/container/container.h"

namespace packmesh {

/// Box; each axis is periodic or ends in two walls.
/// @throws InputError if a side is not positive and finite
std::unique_ptr<Container> makeBox(const Box& box, const std::array<bool, 3>& periodic);

/// Circular cylinder. `axis` 0, 1, 2 = x, y, z; `center` is the midpoint of the axis [µm]; the ends are walls
/// or periodic.
/// @throws InputError if radius or length is not positive and finite
std::unique_ptr<Container> makeCylinder(const Vec3& center, int axis, double radius, double length,
                                        bool periodicEnds);

/// Sphere. Lengths in µm.
/// @throws InputError if the radius is not positive and finite
std::unique_ptr<Container> makeSphere(const Vec3& center, double radius);

}  // namespace packmesh
