// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The innermost loop of the exact mesh test: search for pairs of triangles of two meshes that could be
/// near each other.
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

}  // namespace packmesh
