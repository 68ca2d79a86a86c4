// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The innermost loop of the exact mesh test: which pairs of triangles of two meshes could be near each
/// other.
///
/// Floats with margins: pairs are only ever left out when they are certainly apart, so that verdicts and gaps
/// do not depend on the instruction set. A kernel: see packMesh/simd/instruction_set.h.
#pragma once

#include "packMesh/simd/instruction_set.h"

namespace packmesh {

/// Four patches of a mesh, lane by lane. Patch k lies within `radius` of its center, and between two planes:
/// |normal·(x - center)| <= half [µm]. Unused lanes are infinitely far from everything: their sizes are
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
  int disc;        ///< where that disc is: index of its quad times four plus its lane
};

/// A mesh as the kernel sees it.
struct TreeView {
  const DiscQuad* quads;      ///< the first has one lane, which holds everything
  const float (*corners)[9];  ///< of each triangle, corner by corner
  const int* discs;           ///< where the disc of each triangle is (DiscQuad::disc)
};

/// The second mesh seen from the body frame of the first.
struct SeenFrom {
  float point[3][3], shift[3];  ///< x -> point·x + shift
  float direction[3][3];        ///< normals, to vectors no longer than 1
  float stretch;                ///< lengths grow at most by that
  float slab;  ///< |normal·(x - center)| <= half becomes |direction·normal·(...)| <= slab·half
  float skew;  ///< square of how much longer than the shortest `direction` can be than 1, >= 1
};

/// What is done with a pair of triangles that could be near each other, and perhaps meets. Returns the new
/// limit [frame of the first, µm]; negative: enough is known.
using ExaminePair = float (*)(void* context, int first, int second, bool mayMeet);

/// Calls `examine` for every pair of triangles whose distance may be below `limit` [frame of the first, µm].
/// @param rounding bounds the error of distances computed in floats [frame of the first, µm]
/// @return whether the search went on to its end
using PairSearch = bool(const TreeView& first, const TreeView& second, const SeenFrom& map, float rounding,
                        float limit, ExaminePair examine, void* context);

/// The version for an instruction set. Pre: available(set).
template <InstructionSet set>
PairSearch* pairSearch();
inline PairSearch* pairSearch(InstructionSet set) {
  return forInstructionSet(set, [](auto constant) { return pairSearch<constant.value>(); });
}

}  // namespace packmesh
