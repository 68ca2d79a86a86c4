// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/triangle_pair.h"
#include "tests/packMesh/simd/kernel_inputs.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

using RealTriangle = std::array<Vec3, 3>;

/// Distance of the origin to the hull of the differences of two triangles: the least over all points,
/// segments and triangles of them whose nearest point is interior.
double distanceByDifferences(const RealTriangle& a, const RealTriangle& b) {
  std::vector<Vec3> d;
  for (const Vec3& p : a)
    for (const Vec3& q : b) d.push_back(p - q);
  double least = 1e300;
  for (std::size_t i = 0; i < d.size(); ++i) {
    least = std::min(least, d[i].norm());
    for (std::size_t j = 0; j < d.size(); ++j) {
      const Vec3 e = d[j] - d[i];
      const double s = -d[i].dot(e) / e.squaredNorm();
      if (s > 0.0 && s < 1.0) least = std::min(least, (d[i] + s * e).norm());
      for (std::size_t k = j + 1; k < d.size(); ++k) {
        const Vec3 f = d[k] - d[i], normal = e.cross(f);
        const double squared = normal.squaredNorm();
        if (squared < 1e-18) continue;
        const double st[] = {f.cross(d[i]).dot(normal) / squared, d[i].cross(e).dot(normal) / squared};
        if (st[0] > 0.0 && st[1] > 0.0 && st[0] + st[1] < 1.0)
          least = std::min(least, (d[i] + st[0] * e + st[1] * f).norm());
      }
    }
  }
  return least;
}

double distance(const RealTriangle& a, const RealTriangle& b) {
  return triangleDistance(a[0], a[1], a[2], b[0], b[1], b[2]);
}

}  // namespace

TEST_CASE("triangleDistance agrees with the hull of differences", "[exact]") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0), size(0.05, 2.0);
  int compared = 0;
  for (int i = 0; i < 4000; ++i) {
    RealTriangle a, b;
    const double sizeA = size(random), sizeB = size(random);
    for (Vec3& p : a) p = sizeA * Vec3(coordinate(random), coordinate(random), coordinate(random));
    for (Vec3& p : b) p = sizeB * Vec3(coordinate(random), coordinate(random), coordinate(random));
    if (i % 4 == 0) b[1] = b[0] + (a[1] - a[0]);        // parallel edges
    if (i % 8 == 0) b[2] = b[0] + 0.3 * (a[2] - a[0]);  // parallel faces
    if (trianglesMeet(a[0], a[1], a[2], b[0], b[1], b[2])) continue;
    ++compared;
    const double expected = distanceByDifferences(a, b);
    REQUIRE(distance(a, b) == Approx(expected).margin(1e-12));
    REQUIRE(distance(b, a) == Approx(expected).margin(1e-12));
    const Vec3 far(65536.0, -32768.0, 8192.0);
    for (RealTriangle* t : {&a, &b})
      for (Vec3& p : *t) p += far;
    REQUIRE(distance(a, b) == Approx(expected).margin(1e-10));
  }
  REQUIRE(compared > 1500);
}

TEST_CASE("triangleDistance is right for degenerate and touching triangles", "[exact]") {
  const RealTriangle face = {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)};
  REQUIRE(distance(face, {Vec3(1, 1, 2), Vec3(1, 1, 2), Vec3(1, 1, 2)}) == 2.0);
  REQUIRE(distance(face, {Vec3(-3, -4, 0), Vec3(-3, -4, 0), Vec3(-3, -4, 0)}) == 5.0);
  REQUIRE(distance(face, {Vec3(1, 1, 1), Vec3(1, 1, 3), Vec3(1, 1, 2)}) == 1.0);
  REQUIRE(distance(face, {Vec3(-1, -5, 1), Vec3(-1, 5, 1), Vec3(-1, 0, 1)}) == Approx(std::sqrt(2.0)));
  REQUIRE(distance(face, {Vec3(1, 1, 0), Vec3(2, 1, 1), Vec3(1, 2, 1)}) == 0.0);
  REQUIRE(distance(face, face) == 0.0);
}

// Gaps in reports, and which cells are certified, depend on every bit: these are the bits of the formulas for
// one corner or edge at a time, with branches. Half of the triangles have few different coordinates, so that
// many are segments, points, parallel or touching.
TEST_CASE("triangleDistance has the bits of its formulas one at a time", "[exact]") {
  std::mt19937_64 random(1);
  Hash hash;
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t most = 2 + random() % 4;
    const double size = i % 3 == 0 ? 1e-100 : i % 3 == 1 ? 1.0 : 0.1;
    RealTriangle t[2];
    for (RealTriangle& triangle : t)
      for (Vec3& p : triangle)
        for (double& c : p) c = size * (i % 2 == 0 ? double(random() % most) : double(random() >> 11));
    hash.add(distance(t[0], t[1]));
  }
  REQUIRE(hash.value() == 0x4e7dd89e47cca1bd);
}

TEST_CASE("triangleDistance leaves out corners that are not a number", "[exact]") {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const RealTriangle face = {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)};
  const Vec3 near(-3, 1, 0), above(-3, 1, 1), far(none, 1, 0);
  REQUIRE(distance(face, {near, above, far}) == 3.0);
  REQUIRE(distance({near, above, far}, face) == 3.0);
  REQUIRE(distance({near, far, above}, face) == 3.0);
}
