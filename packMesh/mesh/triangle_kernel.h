// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Search for the nearest triangle, of a few or in the tree of a mesh, for 16 points at once. A kernel:
/// see instruction_set.h.
#pragma once

#include "packMesh/mesh/hierarchy_kernel.h"
#include "packMesh/simd/instruction_set.h"

namespace packmesh {

/// Precomputed data of a triangle for squared distances.
struct TriangleFacts {
  float corner[3][3];  ///< start of each edge [µm]
  float edge[3][3];    ///< vector to the next corner [µm]
  float perSquare[3];  ///< 1 / length² of the edges, 0 for edges of no length
  float inward[3][3];  ///< perpendicular to each edge, in the plane; 0 for a triangle without area
  float normal[3];     ///< unit normal
};

/// Sixteen points.
struct PointLanes {
  float x[16], y[16], z[16];
};

/// For each point the squared distance to the nearest of the triangles `chosen[0 ... count - 1]`, and the
/// index of that triangle in `chosen`.
using NearestTriangles = void (*)(const PointLanes& points, const TriangleFacts* triangles, const int* chosen,
                                  int count, float (&squared)[16], float (&nearest)[16]);

/// Squared distances of the points to each of `count` triangles, 16 floats per triangle.
using TriangleDistances = void (*)(const PointLanes& points, const TriangleFacts* triangles, int count,
                                   float* squared);

/// Examines triangles that may be nearest to a point k: those with squared[16 t + k] <= limits[k], where
/// `limits` may be lowered.
using ExamineNear = void (*)(void* context, const int* triangles, const float* squared, int count,
                             float (&limits)[16]);

/// Squared distances d² from triangles have errors of less than half of searchGrowth d² + slack.
inline constexpr float searchGrowth = 2e-5f;

/// Calls `examine` with all triangles that may be nearest to a point k and nearer than the root of limits[k].
/// @param slack [µm²]
/// @param limits including searchGrowth and slack; negative: no triangle is searched. Lowered by what is
/// found
using SearchNear = void (*)(const PointLanes& points, const DiscQuad* quads, const TriangleFacts* triangles,
                            float slack, float (&limits)[16], ExamineNear examine, void* context);

struct TriangleKernels {
  NearestTriangles nearest;
  TriangleDistances distances;
  SearchNear search;
};

/// The version for an instruction set. Pre: available(set).
template <InstructionSet set>
TriangleKernels triangleKernels();
inline TriangleKernels triangleKernels(InstructionSet set) {
  return forInstructionSet(set, [](auto constant) { return triangleKernels<constant.value>(); });
}

}  // namespace packmesh
