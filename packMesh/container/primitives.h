// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Containers with a closed form: boxes, cylinders, spheres.
///
/// Their distance() is that of the nearest wall (so outside an edge between two walls it is nearer than the
/// true distance), their examine() looks at vertices: they are convex. Touching counts as meeting. The
/// surface() of a cylinder or sphere circumscribes it: whatever is in the lumen is inside that mesh.
#pragma once

#include <array>
#include <memory>

#include "packMesh/container/container.h"

namespace packmesh {

/// Box; each axis is either periodic or ends in two walls.
/// @throws InputError when a side is not positive and finite
std::unique_ptr<Container> makeBox(const Box& box, const std::array<bool, 3>& periodic);

/// Round cylinder. `axis` 0, 1, 2 = x, y, z; `center` is the middle of the axis; ends are walls or periodic.
/// @throws InputError when radius or length is not positive and finite
std::unique_ptr<Container> makeCylinder(const Vec3& center, int axis, double radius, double length,
                                        bool periodicEnds);

/// Sphere.
/// @throws InputError when the radius is not positive and finite
std::unique_ptr<Container> makeSphere(const Vec3& center, double radius);

}  // namespace packmesh
