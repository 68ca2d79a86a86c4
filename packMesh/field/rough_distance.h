// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Signed distance to one of many meshes, each of which needs a grid of its own.
#pragma once

#include "packMesh/field/distance_grid.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// As sampleDistance(), in a tenth of the time: distances are exact at nodes within a spacing of the surface,
/// too large by up to a quarter of a spacing within one and a half, and by up to three quarters elsewhere.
/// Pre: mesh closed and oriented outwards, inside `region`
DistanceGrid sampleRoughly(const TriangleMesh& mesh, const Box& region, double spacing);

}  // namespace packmesh
