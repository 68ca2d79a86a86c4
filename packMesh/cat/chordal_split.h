// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The chordal axis transform (thesis 3.1.2.2, Table 3.1): tetrahedra that join several surfaces are
/// split into one segment for each of them.
///
/// Let s_a(x) be the sum of the barycentric coordinates of x that belong to corners on surface a. The segment
/// of a is the set where no other sum is larger; it is convex, and the faces between segments are planar.
/// They pass through the midpoints of edges, the centroids of triangles with three labels and the centroids
/// of tetrahedra with four. Their intersection with a triangle depends on that triangle alone, so that the
/// segments of adjacent tetrahedra match.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "packMesh/cat/tetrahedra.h"

namespace packmesh {

/// Position of the faces between an object and the container.
enum class WallFaces {
  atWall,  ///< through the container's own corners: the wall does not move, so the object gets all of the gap
  midGap,  ///< half way, as between objects
};

/// Cases of Table 3.1, by the number of corners with each label.
enum class ChordalCase : std::uint8_t { none, threeOne, twoTwo, twoOneOne, allDifferent };

/// Number of faces in each case.
inline constexpr std::array<int, 5> chordalFaceCount = {0, 1, 1, 3, 12};

/// A case, and the order of corners that transforms it to its standard form: p p p q, p p q q, p p q r, p q r
/// s.
struct ChordalPattern {
  ChordalCase kind = ChordalCase::none;
  std::array<std::uint8_t, 4> order{0, 1, 2, 3};
};

/// The pattern of a tetrahedron whose corners have these labels.
const ChordalPattern& chordalPattern(int a, int b, int c, int d);

/// A face between two segments of a tetrahedron.
struct ChordalFace {
  Vec3 point;   ///< in the plane of the face [µm]
  Vec3 normal;  ///< unit, from the first side to the second
  double away;  ///< distance of the corners on both sides from the plane [µm]; 0 for faces at the container
  int tetrahedron;
  std::uint8_t first, second;  ///< corners of the tetrahedron on either side: bit k for corner k

  ChordalFace() {}  // uninitialised: there are hundreds of thousands, and all are filled
};

/// All faces, in the order of the tetrahedra. Each constrains the corners on its sides (v, q, n of the
/// thesis): v is the corner, q and n are the face's point and its normal, reversed for corners on the second
/// side.
struct ChordalFaces {
  std::vector<ChordalFace> faces;
  std::array<std::int64_t, 5> tetrahedra{};  ///< per ChordalCase
};

/// Splits all tetrahedra. The twelve faces of a tetrahedron with four labels are six successive pairs, each
/// in a common plane.
/// @param out overwritten; its memory is reused
void splitChordally(const Tetrahedra& tetrahedra, WallFaces wall, ChordalFaces& out);

}  // namespace packmesh
