// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Objects and their periodic images. Internal to packMesh/cat.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "packMesh/cat/tetrahedra.h"

namespace packmesh {

/// "object 3", or its name if it has one.
std::string nameOf(const TetrahedraInput& input, int object);

/// TetrahedraInput::bodies, or objects translated by whole periods into the bounds and their images up to
/// `margin` outside; sorted by position. Their points are not numbered yet.
std::vector<TetrahedraBody> bodiesAround(const TetrahedraInput& input, double margin);

/// Placement of a body.
Placement placementOf(const TetrahedraInput& input, const TetrahedraBody& body);

/// Surface of the container as far as bodies up to `margin` outside of the bounds can extend; empty without a
/// container.
std::optional<MeshHierarchy> containerAround(const TetrahedraInput& input, double margin);

/// Largest radius of the objects' bounding spheres [µm].
double largestRadius(const TetrahedraInput& input);

}  // namespace packmesh
