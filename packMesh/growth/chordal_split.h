// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The chordal axis transform (thesis 3.1.2.2, Table 3.1): tetrahedra that join several surfaces are
/// cut into one segment for each of them.
///
/// Let s_a(x) be the sum of the barycentric coordinates of x that belong to corners on surface a. The segment
/// of a is where no other sum is larger; it is convex, and faces between segments are planar. They run
/// through middles of edges, centroids of triangles with three labels and centroids of tetrahedra with four,
/// and on a triangle they depend on that triangle alone: the segments of neighbouring tetrahedra match.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "packMesh/growth/face_use.h"
#include "packMesh/growth/tetrahedra.h"

namespace packmesh {

/// Where the faces between an object and the container are.
enum class WallFaces {
  atWall,  ///< through the container's own corners: the wall does not move, so all of the gap is the object's
  midGap,  ///< half way, as between objects
};

/// Cases of Table 3.1 by how many corners have which label.
enum class ChordalCase : std::uint8_t { none, threeOne, twoTwo, twoOneOne, allDifferent };

/// Faces of each case.
inline constexpr std::array<int, 5> chordalFaceCount = {0, 1, 1, 3, 12};

/// A case, and the order of corners that brings it to its standard form: p p p q, p p q q, p p q r, p q r s.
struct ChordalPattern {
  ChordalCase kind = ChordalCase::none;
  std::array<std::uint8_t, 4> order{0, 1, 2, 3};
};

/// The pattern of a tetrahedron whose corners have these labels.
const ChordalPattern& chordalPattern(int a, int b, int c, int d);

/// A face between two segments of a tetrahedron.
struct ChordalFace {
  Vec3 point;   ///< on the face's plane [µm]
  Vec3 normal;  ///< unit, from the first side to the second
  double away;  ///< of its plane from the corners on both sides [µm]; 0 for faces at the container
  int tetrahedron;
  std::uint8_t first, second;  ///< corners of the tetrahedron on either side: bit k for corner k

  ChordalFace() {}  // left as it is: there are hundreds of thousands, and all are filled
};

/// All faces, and which of them each point has to stay behind (v, q, n of the thesis): v is the point, q and
/// n the face's point and, times FaceUse::sign(), normal.
struct ChordalFaces {
  std::vector<ChordalFace> faces;
  std::vector<int>
      firstUse;  ///< per point and one more: those of point p are uses[firstUse[p]] ... before the next
  std::vector<FaceUse> uses;
  std::array<std::int64_t, 5> tetrahedra{};  ///< per ChordalCase
};

/// Cuts all tetrahedra. The twelve faces of a tetrahedron with four labels are six pairs in a common plane,
/// one after the other.
/// @param out replaced; its memory is used again
void splitChordally(const Tetrahedra& tetrahedra, WallFaces wall, ChordalFaces& out);

}  // namespace packmesh
