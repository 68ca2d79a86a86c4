// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/mesh_intersection.h"

#include "packMesh/core/error.h"
#include "packMesh/mesh/convex_hull.h"
#include "packMesh/mesh/triangle_pair.h"
#include "tests/packMesh/mesh/test_meshes.h"
#include "tests/packMesh/mesh/winding_number.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

bool surrounds(const TriangleMesh& mesh, const Vec3& p) {
  return std::abs(solidAngle(mesh.vertices, mesh.triangles, p)) > 2.0 * M_PI;
}

/// All pairs of triangles, one by one, but for those whose boxes are further apart than `interest`.
/// Pre: meshes in one piece.
MeshPairResult bruteForce(const TriangleMesh& a, const TriangleMesh& b, double interest) {
  MeshPairResult out;
  const auto boxes = [](const TriangleMesh& mesh, double margin) {
    std::vector<Box> all(mesh.triangles.size());
    for (std::size_t t = 0; t < all.size(); ++t) {
      for (int v : mesh.triangles[t]) all[t].add(mesh.vertices[v]);
      all[t] = all[t].grownBy(margin);
    }
    return all;
  };
  const std::vector<Box> boxesA = boxes(a, interest), boxesB = boxes(b, 0.0);
  for (int i = 0; i < int(a.triangles.size()); ++i)
    for (int j = 0; j < int(b.triangles.size()); ++j) {
      if (!boxesA[i].meets(boxesB[j])) continue;
      const auto p = [&](int k) -> const Vec3& { return a.corner(i, k); };
      const auto q = [&](int k) -> const Vec3& { return b.corner(j, k); };
      if (trianglesMeet(p(0), p(1), p(2), q(0), q(1), q(2))) return {MeshRelation::meet, 0.0};
      out.gap = std::min(out.gap, triangleDistance(p(0), p(1), p(2), q(0), q(1), q(2)));
    }
  if (surrounds(b, a.vertices[0])) return {MeshRelation::firstInside, 0.0};
  if (surrounds(a, b.vertices[0])) return {MeshRelation::secondInside, 0.0};
  return out;
}

MeshRelation swapped(MeshRelation r) {
  return r == MeshRelation::firstInside    ? MeshRelation::secondInside
         : r == MeshRelation::secondInside ? MeshRelation::firstInside
                                           : r;
}

/// relate(), checked for agreement with itself: swapped, without a gap, with other interests.
MeshPairResult relateEveryWay(const MeshHierarchy& a, const Placement& pa, const MeshHierarchy& b,
                              const Placement& pb, double interest) {
  const MeshPairResult result = relate(a, pa, b, pb, interest);
  REQUIRE(relate(a, pa, b, pb).relation == result.relation);
  const MeshPairResult other = relate(b, pb, a, pa, interest);
  REQUIRE(other.relation == swapped(result.relation));
  if (result.gap < infinite)
    REQUIRE(other.gap == Approx(result.gap).margin(1e-11));
  else
    REQUIRE(other.gap == infinite);
  if (result.gap > 0.0 && result.gap < infinite) {
    REQUIRE(relate(a, pa, b, pb, 2.0 * result.gap).gap == result.gap);
    REQUIRE(relate(a, pa, b, pb, 0.999 * result.gap).gap == infinite);
  }
  return result;
}

struct Counts {
  int apart = 0, meet = 0, near = 0;
};

void compare(const MeshHierarchy& a, const Placement& pa, const MeshHierarchy& b, const Placement& pb,
             double interest, Counts& counts) {
  const MeshPairResult expected = bruteForce(placed(a.mesh(), pa), placed(b.mesh(), pb), interest);
  const MeshPairResult result = relateEveryWay(a, pa, b, pb, interest);
  REQUIRE(result.relation == expected.relation);
  if (expected.gap < interest)
    REQUIRE(result.gap == Approx(expected.gap).epsilon(1e-12).margin(1e-12));
  else
    REQUIRE(result.gap == infinite);
  counts.meet += expected.relation == MeshRelation::meet;
  counts.apart += expected.relation == MeshRelation::apart;
  counts.near += result.gap < infinite && result.gap > 0.0;
}

}  // namespace

TEST_CASE("relate agrees with brute force for red cells at all distances and orientations", "[exact]") {
  const MeshHierarchy coarse(test::redCell(1)), fine(test::redCell(2));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> distance(1.2, 7.8), scale(0.4, 1.1), coordinate(-100.0, 100.0);
  Counts counts;
  for (int i = 0; i < 600; ++i) {
    const Placement a{test::randomRotation(random),
                      Vec3(coordinate(random), coordinate(random), coordinate(random))};
    const Placement b{(i % 2 ? 1.0 : scale(random)) * test::randomRotation(random),
                      a.translation + distance(random) * test::randomDirection(random)};
    compare(i % 3 ? coarse : fine, a, coarse, b, 0.5, counts);
  }
  REQUIRE(counts.apart > 100);
  REQUIRE(counts.meet > 100);
  REQUIRE(counts.near > 30);
}

TEST_CASE("relate is exact for nested and stacked red cells down to gaps of 1e-12 µm", "[exact]") {
  const MeshHierarchy cell(test::redCell(2));
  std::mt19937 random(2);
  std::uniform_real_distribution<double> tilt(-0.15, 0.15), exponent(-12.0, -1.0);
  Counts counts;
  for (int i = 0; i < 60; ++i) {
    const Placement a{test::randomRotation(random), Vec3(20, 30, 40)};
    const Vec3 axis = a.linear.col(2);
    const Mat3 turned =
        a.linear * Quaternion::around(test::randomDirection(random), tilt(random)).toRotationMatrix();
    // The height at which they touch, by bisection, then a little more or less.
    double lo = 0.5, hi = 3.5;
    const auto at = [&](double h) { return Placement{turned, a.translation + h * axis}; };
    while (hi - lo > 1e-14 * hi) {
      const double middle = 0.5 * (lo + hi);
      if (middle <= lo || middle >= hi) break;
      (relate(cell, a, cell, at(middle)).relation == MeshRelation::meet ? lo : hi) = middle;
    }
    const double beside = std::pow(10.0, exponent(random));
    compare(cell, a, cell, at(hi + beside), 1.0, counts);
    compare(cell, a, cell, at(lo - beside), 1.0, counts);
    compare(cell, a, cell, at(hi), 1.0, counts);
    compare(cell, a, cell, at(lo), 1.0, counts);
  }
  REQUIRE(counts.apart >= 100);
  REQUIRE(counts.meet >= 100);
}

TEST_CASE("relate is exact for very different sizes, distant positions and general affine placements",
          "[exact]") {
  const MeshHierarchy large(test::icosphere(2, 9.0)), small(sample::box({-1, -1, -1}, {1, 1, 1}));
  const MeshHierarchy ring(sample::torus(Vec3(1, 2, 3), 3.0, 0.5, 16, 8));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> distance(8.0, 11.0), unit(-1.0, 1.0);
  Counts counts;
  for (int i = 0; i < 300; ++i) {
    const Vec3 at = i % 3 == 0 ? Vec3(91234.5, -87654.3, 99999.0) : Vec3(1.0, 2.0, 3.0);
    Placement a{test::randomRotation(random), at};
    Placement b{test::randomRotation(random), at + distance(random) * test::randomDirection(random)};
    if (i % 2) {  // sheared, stretched, mirrored
      for (Placement* p : {&a, &b})
        for (int k = 0; k < 9; ++k) p->linear.data()[k] += 0.3 * unit(random);
      if (i % 4 == 1) b.linear.col(0) *= -1.0;
    }
    compare(large, a, i % 5 ? small : ring, b, 0.7, counts);
  }
  REQUIRE(counts.apart > 50);
  REQUIRE(counts.meet > 50);
  REQUIRE(counts.near > 20);
}

TEST_CASE("Boxes that share a face, an edge or a corner meet, and one bit apart they do not", "[exact]") {
  const MeshHierarchy cube(sample::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}));
  const auto relation = [&](const Vec3& at) {
    return relateEveryWay(cube, {}, cube, {Mat3::Identity(), at}, 0.1).relation;
  };
  const double beyond = std::nextafter(1.0, 2.0);
  for (double y : {0.0, 0.3, 1.0, -1.0})
    for (double z : {0.0, 0.25, 1.0, -1.0}) {
      REQUIRE(relation({1.0, y, z}) == MeshRelation::meet);
      REQUIRE(relation({-1.0, y, z}) == MeshRelation::meet);
      REQUIRE(relation({beyond, y, z}) == MeshRelation::apart);
      REQUIRE(relation({-beyond, y, z}) == MeshRelation::apart);
      REQUIRE(relation({z, beyond, y}) == MeshRelation::apart);
    }
  REQUIRE(relation({0, 0, 0}) == MeshRelation::meet);
  REQUIRE(relate(cube, {}, cube, {Mat3::Identity(), {1.25, 0.5, 0.0}}, 1.0).gap == 0.25);
  REQUIRE(relate(cube, {}, cube, {Mat3::Identity(), {1.3, 1.4, 0.0}}, 1.0).gap == Approx(0.5));
  REQUIRE(relate(cube, {}, cube, {Mat3::Identity(), {1.25, 0.5, 0.0}}, 0.25).gap == infinite);
}

TEST_CASE("relate recognises a mesh entirely inside another one", "[exact]") {
  const MeshHierarchy cell(test::redCell(2)), box(sample::box({-6, -6, -6}, {6, 6, 6}));
  std::mt19937 random(4);
  std::uniform_real_distribution<double> offset(0.0, 2.0);
  for (int i = 0; i < 50; ++i) {
    const Placement outer{test::randomRotation(random), Vec3(3, 2, 1)};
    const Placement inner{test::randomRotation(random),
                          outer.translation + offset(random) * test::randomDirection(random)};
    const MeshPairResult result = relateEveryWay(cell, inner, box, outer, 1.0);
    REQUIRE(result.relation == MeshRelation::firstInside);
    REQUIRE(result.gap == 0.0);
  }
  // A copy shrunk by 1e-9: its volume is no help.
  const Placement whole{test::randomRotation(random), Vec3(10, 20, 30)};
  const MeshHierarchy ball(test::icosphere(2, 3.0));
  REQUIRE(relateEveryWay(ball, {whole.linear * (1.0 - 1e-9), whole.translation}, ball, whole, 1.0).relation ==
          MeshRelation::firstInside);
  REQUIRE(relateEveryWay(ball, {whole.linear * (1.0 + 1e-9), whole.translation}, ball, whole, 1.0).relation ==
          MeshRelation::secondInside);
  REQUIRE(relateEveryWay(ball, whole, ball, whole, 1.0).relation == MeshRelation::meet);
  // In the hole of a ring: apart.
  const MeshHierarchy ring(sample::torus(Vec3::Zero(), 3.0, 0.5, 24, 12));
  REQUIRE(relateEveryWay(ring, {}, ball, {0.5 * Mat3::Identity(), Vec3::Zero()}, 2.0).relation ==
          MeshRelation::apart);
}

TEST_CASE("relate is exact for meshes of several parts", "[exact]") {
  TriangleMesh two = test::icosphere(1, 1.0), hollow = test::icosphere(1, 5.0),
               cavity = test::icosphere(1, 4.0);
  sample::append(two, placed(test::icosphere(1, 1.0), {Mat3::Identity(), Vec3(10, 0, 0)}));
  flip(cavity);
  sample::append(hollow, cavity);
  const MeshHierarchy pair(two), shell(hollow), ball(test::icosphere(1, 3.0));
  const auto at = [](double x) { return Placement{Mat3::Identity(), Vec3(x, 0, 0)}; };
  REQUIRE(relateEveryWay(pair, at(0), ball, at(0), 0.0).relation ==
          MeshRelation::meet);  // one part is inside
  REQUIRE(relateEveryWay(pair, at(0), ball, at(5), 0.0).relation == MeshRelation::apart);
  REQUIRE(relateEveryWay(shell, at(0), ball, at(0.1), 0.0).relation == MeshRelation::apart);  // in the cavity
  REQUIRE(relateEveryWay(shell, at(0), ball, at(1), 0.0).relation == MeshRelation::meet);
}

TEST_CASE("isInside agrees with the solid angle, and is true on the surface", "[exact]") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(-4.5, 4.5), weight(0.0, 1.0);
  for (const TriangleMesh& mesh : {test::redCell(2), sample::box({-2, -2, -2}, {2, 2, 2}),
                                   sample::torus(Vec3(0.5, 0, 0), 2.5, 0.8, 20, 10)}) {
    const MeshHierarchy hierarchy(mesh);
    const Placement placement{1.1 * test::randomRotation(random), Vec3(5, 6, 7)};
    const TriangleMesh world = placed(mesh, placement);
    int inside = 0;
    for (int i = 0; i < 1500; ++i) {
      const Vec3 p = placement(Vec3(coordinate(random), coordinate(random), 0.5 * coordinate(random)));
      const bool expected = surrounds(world, p);
      REQUIRE(isInside(p, hierarchy, placement) == expected);
      inside += expected;
    }
    REQUIRE(inside > 50);
    for (const Vec3& v : world.vertices) REQUIRE(isInside(v, hierarchy, placement));
  }
}

TEST_CASE("What a surface covers twice, or inside out, is inside", "[exact]") {
  TriangleMesh two = sample::box({0, 0, 0}, {4, 4, 4});
  sample::append(two, sample::box({1, 1, 1}, {5, 5, 5}));
  const MeshHierarchy twice(two);
  for (const Vec3& p : {Vec3(2, 2, 2), Vec3(0.5, 0.5, 0.5), Vec3(4.5, 4.5, 4.5)})
    CHECK(isInside(p, twice, {}));
  CHECK_FALSE(isInside({0.5, 0.5, 4.5}, twice, {}));
  for (Triangle& t : two.triangles) std::swap(t[1], t[2]);
  CHECK(isInside({2, 2, 2}, MeshHierarchy(two), {}));
  // A mesh in what another one covers twice overlaps it.
  const MeshHierarchy small(sample::box({2, 2, 2}, {2.5, 2.5, 2.5}));
  CHECK(relate(twice, {}, small, {}).relation == MeshRelation::secondInside);
  CHECK(relate(small, {}, twice, {}).relation == MeshRelation::firstInside);
}

TEST_CASE("isInside is exact for points in line with vertices, edges and faces", "[exact]") {
  const MeshHierarchy box(sample::box({0, 0, 0}, {4, 4, 4}));
  const double below = -1e-80, above = std::nextafter(4.0, 5.0);
  for (double x : {below, 0.0, 1.0, 2.0, 4.0, above})
    for (double y : {below, 0.0, 1.0, 2.0, 4.0, above})
      for (double z : {below, 0.0, 1.0, 2.0, 4.0, above}) {
        const bool expected = std::min({x, y, z}) >= 0.0 && std::max({x, y, z}) <= 4.0;
        REQUIRE(isInside({x, y, z}, box, {}) == expected);
      }
}

TEST_CASE("The support of the convex hull is that of all vertices", "[exact]") {
  std::mt19937 random(6);
  TriangleMesh doubled = sample::box({0, 0, 0}, {1, 2, 3});
  sample::append(doubled, sample::box({0, 0, 0}, {1, 2, 3}));  // repeated and coplanar points
  TriangleMesh flat;
  flat.vertices = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {2, 2, 0}};
  flat.triangles = {{0, 1, 2}, {1, 3, 2}};
  for (const TriangleMesh& mesh :
       {test::redCell(3), test::icosphere(2), doubled, flat, sample::torus(Vec3(5, 5, 5), 3, 1, 12, 8)}) {
    const ConvexHull hull(mesh);
    for (int i = 0; i < 2000; ++i) {
      Vec3 direction = test::randomDirection(random);
      if (i % 4 == 0) direction = direction.array().round();
      if (direction.isZero()) continue;
      double most = -infinite;
      for (const Vec3& v : mesh.vertices) most = std::max(most, direction.dot(v));
      REQUIRE(direction.dot(hull.points()[hull.furthest(direction)]) == Approx(most).margin(1e-12));
    }
  }
}

TEST_CASE("A mesh without triangles is rejected", "[exact]") {
  REQUIRE_THROWS_AS(MeshHierarchy(TriangleMesh{}), MeshError);
}
