// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The innermost loops over the tree of a mesh. Kernels: see instruction_set.h.
///
/// Computes in floats with margins: only pairs that are certainly apart are discarded, so that results do not
/// depend on the instruction set. A kernel: see packMesh/simd/instruction_set.h.
#pragma once

#include "packMesh/simd/instruction_set.h"

namespace packmesh {

/// Four patches of a mesh, lane by lane. Patch k lies within `radius` of its centre and between two planes:
/// normal·(x - center)| <= half [µm]. Unused lanes are infinitely far from everything: their sizes are
/// -emptyDisc.
struct FourDiscs {
  float center[3][4], normal[3][4], radius[4], half[4];
};
constexpr float emptyDisc = 1e30f;

/// The children of a node of MeshTree.
struct DiscQuad {
  FourDiscs discs;
  int content[4];  ///< >= 0: index of a quad, else ~index of a triangle
  float size;      ///< radius of the disc around all four [µm]
  int disc;        ///< position of that disc: index of its quad times four plus its lane
};

/// The mesh data used by the kernel.
struct TreeView {
  const DiscQuad* quads;  ///< the first has one lane, which contains the whole mesh
  const float (*vertices)[3];
  const int (*triangles)[3];  ///< indices of their corners
  const int* discs;           ///< position of each triangle's disc (DiscQuad::disc)
};

/// Map from the body frame of the second mesh to that of the first.
struct SeenFrom {
  float point[3][3], shift[3];  ///< x -> point·x + shift
  float direction[3][3];        ///< maps normals to vectors no longer than 1
  float stretch;                ///< largest factor by which lengths grow
  float slab;  ///< |normal·(x - center)| <= half becomes |direction·normal·(...)| <= slab·half
  float skew;  ///< square of the reciprocal of the shortest mapped normal, >= 1
};

/// Examines a pair of triangles that could be near each other and, if `mayMeet`, could meet. Returns the new
/// limit [frame of the first, µm]; negative: stop the search.
using ExaminePair = float (*)(void* context, int first, int second, bool mayMeet);

/// Calls `examine` for every pair of triangles whose distance could be below `limit` [frame of the first,
/// µm].
/// @param rounding upper bound of the error of distances computed in floats [frame of the first, µm]
/// @return true if the search was completed
using PairSearch = bool(const TreeView& first, const TreeView& second, const SeenFrom& map, float rounding,
                        float limit, ExaminePair examine, void* context);

/// The version for an instruction set. Pre: available(set).
template <InstructionSet set>
PairSearch* pairSearch();
inline PairSearch* pairSearch(InstructionSet set) {
  return forInstructionSet(set, [](auto constant) { return pairSearch<constant.value>(); });
}

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

/// A triangle lies within `radius` of the centre and at most `half` from the plane through it [µm].
struct TriangleDisc {
  double center[3];
  float normal[3], radius, half;
};

/// Candidates for the nearest triangles of points.
struct NearDiscs {
  /// Centres, relative to the origin of the points, and radii of their discs. After the last candidate, so
  /// many that are far away that all are a multiple of sixteen.
  const float *x, *y, *z, *radius;
  const int* triangles;       ///< indices of the candidates
  const TriangleDisc* discs;  ///< of all triangles
  int count;
};

/// The facts of a candidate, relative to the origin of the points; valid until the next call.
using CandidateFacts = const TriangleFacts& (*)(void* context, int candidate);

/// For each point the squared distance to the nearest candidate, and the index of that candidate. Asks only
/// for the facts of those that may be nearest.
/// @param slack [µm²]
/// @param scratch as many floats as centres
using NearestTriangles = void (*)(const PointLanes& points, const NearDiscs& near, float slack,
                                  float* scratch, CandidateFacts factsOf, void* context, float (&squared)[16],
                                  float (&nearest)[16]);

/// Examines triangles that may be nearest to a point k: those with squared[16 t + k] <= limits[k], where
/// `limits` may be lowered.
using ExamineNear = void (*)(void* context, const int* triangles, const float* squared, int count,
                             float (&limits)[16]);

/// Squared distances d² from triangles have errors of less than half of searchGrowth d² + slack.
inline constexpr float searchGrowth = 2e-5f;

/// That slack where coordinates are up to `extent` [µm²]: distances d have errors e of up to 16 roundings of
/// floats of this size; twice the error of d², 4 d e + 2 e², is less than searchGrowth d² + this.
constexpr double searchSlack(double extent) {
  constexpr double sixteenRoundings = 1e-6;
  const double error = sixteenRoundings * extent;
  return (4.0 / searchGrowth + 2.0) * error * error;
}

/// Calls `examine` with all triangles that may be nearest to a point k and nearer than the root of limits[k].
/// @param slack [µm²]
/// @param limits including searchGrowth and slack; negative: no triangle is searched. Lowered by what is
/// found
using SearchNear = void (*)(const PointLanes& points, const DiscQuad* quads, const TriangleFacts* triangles,
                            float slack, float (&limits)[16], ExamineNear examine, void* context);

struct TriangleKernels {
  NearestTriangles nearest;
  SearchNear search;
};

/// The version for an instruction set. Pre: available(set).
template <InstructionSet set>
TriangleKernels triangleKernels();
inline TriangleKernels triangleKernels(InstructionSet set) {
  return forInstructionSet(set, [](auto constant) { return triangleKernels<constant.value>(); });
}

}  // namespace packmesh
