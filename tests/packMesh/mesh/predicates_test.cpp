// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/predicates.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/packMesh/mesh/integer_oracle.h"

void exactinit(int verbose, int noexact, int nofilter, double maxx, double maxy, double maxz);

using namespace packmesh;
using test::IntegerPoint;
using test::Wide;

namespace {

/// Four points in, or one unit beside, a plane.
struct NearlyCoplanar {
  IntegerPoint a, b, c, p;

  explicit NearlyCoplanar(std::mt19937& random) {
    std::uniform_int_distribution<long> coordinate(-(1L << 24), 1L << 24), factor(-2, 2);
    const long i = factor(random), j = factor(random);
    for (int k = 0; k < 3; ++k) {
      a[k] = coordinate(random), b[k] = coordinate(random), c[k] = coordinate(random);
      p[k] = a[k] + i * (b[k] - a[k]) + j * (c[k] - a[k]);
    }
    p[random() % 3] += static_cast<long>(random() % 3) - 1;
  }
};

void compareWithIntegers(unsigned seed) {
  std::mt19937 random(seed);
  int signs[3] = {0, 0, 0};
  for (int i = 0; i < 20000; ++i) {
    const NearlyCoplanar points(random);
    // Any power of two is exact; with an odd factor every bit of the coordinates is in use.
    const double scale = std::ldexp(1.0, static_cast<int>(random() % 60) - 40);
    const auto real = [&](const IntegerPoint& v) { return Vec3(scale * v[0], scale * v[1], scale * v[2]); };
    const Vec3 a = real(points.a), b = real(points.b), c = real(points.c), p = real(points.p);
    const int expected = test::sign(test::volume(points.a, points.b, points.c, points.p));
    ++signs[expected + 1];
    REQUIRE(sideOfPlane(a, b, c, p) == expected);
    REQUIRE(sideOfPlane(b, c, a, p) == expected);
    REQUIRE(sideOfPlane(b, a, c, p) == -expected);
    REQUIRE(sideOfPlane(p, b, c, a) == -expected);
  }
  for (int count : signs) REQUIRE(count > 1000);
}

}  // namespace

TEST_CASE("sideOfPlane is positive on the outer side of a triangle", "[exact]") {
  REQUIRE(sideOfPlane({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, 1e-80}) == 1);
  REQUIRE(sideOfPlane({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, -1e-80}) == -1);
  REQUIRE(sideOfPlane({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {7, -3, 0}) == 0);
  REQUIRE(sideOfPlane({1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {7, -3, 0}) == 0);
}

TEST_CASE("sideOfPlane agrees with integer arithmetic in and near planes", "[exact]") {
  compareWithIntegers(1);
}

TEST_CASE("sideOfPlane is exact one unit away from a plane, where the filter is inconclusive", "[exact]") {
  std::mt19937 random(4);
  std::uniform_int_distribution<long> small(-8, 8);
  int signs[3] = {0, 0, 0};
  for (int i = 0; i < 50000; ++i) {
    IntegerPoint a, b, c, p, offset;
    for (int k = 0; k < 3; ++k) {
      a[k] = small(random), b[k] = small(random), c[k] = small(random);
      p[k] = b[k] + c[k] - a[k];  // in the plane
      offset[k] = static_cast<long>(random() % 3) - 1;
    }
    const auto real = [](const IntegerPoint& v, const IntegerPoint& o) {
      Vec3 out;
      for (int k = 0; k < 3; ++k) out[k] = static_cast<double>(v[k] * (1L << 47) + o[k]);
      return out;
    };
    const IntegerPoint beside = {a[0] + offset[0], a[1] + offset[1], a[2] + offset[2]};
    const int expected = test::sign(test::volume(a, b, c, beside));
    ++signs[expected + 1];
    const IntegerPoint none = {0, 0, 0};
    REQUIRE(sideOfPlane(real(a, none), real(b, none), real(c, none), real(p, offset)) == expected);
    REQUIRE(sideOfPlane(real(c, none), real(b, none), real(a, none), real(p, offset)) == -expected);
  }
  for (int count : signs) REQUIRE(count > 1000);
}

TEST_CASE("A static filter left behind by TetGen has no effect", "[exact]") {
  exactinit(0, 0, 0, 1e-30, 1e-30, 1e-30);
  compareWithIntegers(2);
  exactinit(0, 1, 0, 1e30, 1e30, 1e30);
  compareWithIntegers(3);
  exactinit(0, 0, 0, 1.0, 1.0, 1.0);
}

TEST_CASE("turn agrees with integer arithmetic around a line, bit by bit", "[exact]") {
  // The grid of L. Kettner et al., "Classroom examples of robustness problems in geometric computations"
  // (2008).
  const double ulp = std::ldexp(1.0, -53);
  const auto scaled = [](double x) { return static_cast<Wide>(std::ldexp(x, 53)); };
  for (int i = 0; i < 128; ++i)
    for (int j = 0; j < 128; ++j) {
      const Eigen::Vector2d p(0.5 + i * ulp, 0.5 + j * ulp), q(12.0, 12.0), r(24.0, 24.0);
      const Wide determinant = (scaled(q[0]) - scaled(p[0])) * (scaled(r[1]) - scaled(p[1])) -
                               (scaled(q[1]) - scaled(p[1])) * (scaled(r[0]) - scaled(p[0]));
      REQUIRE(turn(p, q, r) == test::sign(determinant));
      REQUIRE(turn(q, r, p) == test::sign(determinant));
      REQUIRE(turn(q, p, r) == -test::sign(determinant));
    }
  REQUIRE(turn({0, 0}, {1, 0}, {0, 1}) == 1);
}
