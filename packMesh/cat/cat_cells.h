// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file CAT cells (thesis 3.1.2.2) as closed surfaces, for visualisation, measurement and tests. Growth only
/// needs the planes of their faces (cat_cells.h).
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "packMesh/cat/tetrahedra.h"

namespace packmesh {

// The chordal axis transform (thesis 3.1.2.2, Table 3.1): tetrahedra that join several surfaces are
// split into one segment for each of them.
//
// Let s_a(x) be the sum of the barycentric coordinates of x that belong to corners on surface a. The segment
// of a is the set where no other sum is larger; it is convex, and the faces between segments are planar.
// They pass through the midpoints of edges, the centroids of triangles with three labels and the centroids
// of tetrahedra with four. Their intersection with a triangle depends on that triangle alone, so that the
// segments of adjacent tetrahedra match.

/// Position of the faces between an object and the container.
enum class WallFaces {
  atWall,  ///< through the container's own corners: the wall does not move, so the object gets all of the gap
  midGap,  ///< half way, as between objects
};

/// Cases of Table 3.1, by the number of corners with each label.
enum class ChordalCase : std::uint8_t { none, threeOne, twoTwo, twoOneOne, allDifferent };

/// A face between two segments of a tetrahedron with corners a, b, c, d in standard form (ChordalPattern).
/// Sets of corners are masks, a is 1.
struct ChordalCut {
  int first, second;  ///< corners on either side
  /// The corners of the face: midpoints and centroids of these corners of the tetrahedron, counter-clockwise
  /// as seen from the second side if the tetrahedron has a positive volume. 0 after the last.
  std::array<int, 4> polygon;
  /// Normal of its plane, of any length and sign.
  Vec3 (*normal)(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);
  bool twice = false;  ///< one of two faces in a plane, of which the polygon is the union
};

/// Normal of the plane through the middle of edge ij and p and q.
inline Vec3 normalThrough(const Vec3& i, const Vec3& j, const Vec3& p, const Vec3& q) {
  const Vec3 middle = 0.5 * (i + j);
  return (p - middle).cross(q - middle);
}

/// The faces of each case: Table 3.1.
template <ChordalCase>
inline constexpr std::array<ChordalCut, 0> chordalCuts{};

// A table: clang-format would give every number a line.
// clang-format off
template <>
inline constexpr std::array<ChordalCut, 1> chordalCuts<ChordalCase::threeOne> = {{
    {0b0111, 0b1000, {0b1001, 0b1010, 0b1100}, [](auto& a, auto& b, auto& c, auto&) -> Vec3 { return (b - a).cross(c - a); }}}};
template <>
inline constexpr std::array<ChordalCut, 1> chordalCuts<ChordalCase::twoTwo> = {{
    {0b0011, 0b1100, {0b0101, 0b1001, 0b1010, 0b0110},
     [](auto& a, auto& b, auto& c, auto& d) -> Vec3 { return (b - a).cross(d - c); }}}};
template <>
inline constexpr std::array<ChordalCut, 3> chordalCuts<ChordalCase::twoOneOne> = {{
    {0b0011, 0b0100, {0b0101, 0b1101, 0b1110, 0b0110},
     [](auto& a, auto& b, auto& c, auto& d) -> Vec3 { return (b - a).cross(2.0 * d - a - c); }},
    {0b0011, 0b1000, {0b1001, 0b1010, 0b1110, 0b1101},
     [](auto& a, auto& b, auto& c, auto& d) -> Vec3 { return (b - a).cross(2.0 * c - a - d); }},
    {0b0100, 0b1000, {0b1100, 0b1101, 0b1110},
     [](auto& a, auto& b, auto& c, auto& d) -> Vec3 { return (b - a).cross(2.0 * a - c - d); }}}};
template <>
inline constexpr std::array<ChordalCut, 6> chordalCuts<ChordalCase::allDifferent> = {{
    {0b0001, 0b0010, {0b0011, 0b0111, 0b1111, 0b1011}, [](auto& a, auto& b, auto& c, auto& d) { return normalThrough(a, b, c, d); }, true},
    {0b0001, 0b0100, {0b0101, 0b1101, 0b1111, 0b0111}, [](auto& a, auto& b, auto& c, auto& d) { return normalThrough(a, c, b, d); }, true},
    {0b0001, 0b1000, {0b1001, 0b1011, 0b1111, 0b1101}, [](auto& a, auto& b, auto& c, auto& d) { return normalThrough(a, d, b, c); }, true},
    {0b0010, 0b0100, {0b0110, 0b0111, 0b1111, 0b1110}, [](auto& a, auto& b, auto& c, auto& d) { return normalThrough(b, c, a, d); }, true},
    {0b0010, 0b1000, {0b1010, 0b1110, 0b1111, 0b1011}, [](auto& a, auto& b, auto& c, auto& d) { return normalThrough(b, d, a, c); }, true},
    {0b0100, 0b1000, {0b1100, 0b1101, 0b1111, 0b1110}, [](auto& a, auto& b, auto& c, auto& d) { return normalThrough(c, d, a, b); }, true}}};
// clang-format on

/// The first of a set of corners.
constexpr int lowestCorner(int corners) {
  return corners & 1 ? 0 : corners & 2 ? 1 : corners & 4 ? 2 : 3;
}

/// Calls `use` with a case as std::integral_constant.
template <class Use>
void withCase(ChordalCase kind, Use&& use) {
  if (kind == ChordalCase::threeOne) use(std::integral_constant<ChordalCase, ChordalCase::threeOne>());
  if (kind == ChordalCase::twoTwo) use(std::integral_constant<ChordalCase, ChordalCase::twoTwo>());
  if (kind == ChordalCase::twoOneOne) use(std::integral_constant<ChordalCase, ChordalCase::twoOneOne>());
  if (kind == ChordalCase::allDifferent)
    use(std::integral_constant<ChordalCase, ChordalCase::allDifferent>());
}

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

/// The CAT cell of every object: the object and the adjacent segments of tetrahedra that belong to it.
struct CatCells {
  /// Per object, at its given position: closed, outward-oriented two-manifold surfaces [µm]. Adjacent cells
  /// share faces with the same vertices and triangles, in opposite orientation. With faces at the wall, parts
  /// of a cell's surface may touch in vertices or edges on the container; these have separate vertices.
  std::vector<TriangleMesh> cells;
  /// The part that belongs to the container: with faces in mid-gap, the layer along its wall, otherwise
  /// empty. Only without periodic images.
  TriangleMesh wallLayer;
};

/// The CAT cells of all objects. With faces at the wall, they fill the container: tetrahedra with all corners
/// on the container are assigned to the cell with which they share the largest face. Pre: the tetrahedra fill
/// the free space (TetrahedraKept::freeSpace, constrained), within a container, along every axis that is not
/// periodic.
CatCells catCells(const Tetrahedra& tetrahedra, WallFaces wall);

}  // namespace packmesh
