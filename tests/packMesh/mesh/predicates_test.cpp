// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/predicates.h"

#include "tests/packMesh/mesh/rational_oracle.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

using Tetrad = test::Points<4>;
using Triad = test::Points<3>;
using Random = std::mt19937_64;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

int integer(Random& random, int low, int high) {
  return std::uniform_int_distribution<int>(low, high)(random);
}

/// Of all magnitudes from 2^low to 2^high, with few bits or all.
double anyNumber(Random& random, int low, int high) {
  const double mantissa = integer(random, 0, 2) == 0 ? integer(random, 1, 7) : uniform(random, 1.0, 2.0);
  const double x = std::ldexp(mantissa, integer(random, low, high));
  return integer(random, 0, 1) == 0 ? x : -x;
}

/// Moves one coordinate to a neighbouring double, in two of three cases.
template <class Points>
void nudge(Points& points, Random& random) {
  double& x = points[random() % points.size()][random() % points[0].size()];
  const int direction = integer(random, -1, 1);
  if (direction != 0) x = std::nextafter(x, direction * std::numeric_limits<double>::infinity());
}

/// Points of a plane, or a line, as far as rounding allows, or exactly.
template <class Points>
Points inAPlane(Random& random) {
  const bool exactly = integer(random, 0, 1) == 0;
  const auto number = [&](double low, double high, int bits) {
    const double x = uniform(random, low, high);
    return exactly ? std::ldexp(std::round(std::ldexp(x, bits)), -bits) : x;
  };
  Points points;
  for (auto& point : points)
    for (double& x : point) x = number(-100.0, 100.0, 40);
  const std::size_t last = points.size() - 1;
  double weight[3], sum = 0.0;
  for (std::size_t i = 1; i < last; ++i) sum += weight[i] = number(-2.0, 2.0, 2);
  weight[0] = 1.0 - sum;
  for (std::size_t k = 0; k < last; ++k) {
    points[last][k] = 0.0;
    for (std::size_t i = 0; i < last; ++i) points[last][k] += weight[i] * points[i][k];
  }
  nudge(points, random);
  return points;
}

/// Points of a cell's mesh that is turned by a few degrees: rounded images of coplanar points.
template <class Points>
Points turnedGrid(Random& random) {
  const double angle = uniform(random, 0.0, 0.1), c = std::cos(angle), s = std::sin(angle);
  Points points;
  for (auto& point : points) {
    for (double& x : point) x = 0.125 * integer(random, -4, 4);
    if (point.size() == 3) point[2] = 0.5;
    const double x = point[0], y = point.back();
    point[0] = c * x - s * y + 50.0, point.back() = s * x + c * y + 20.0;
  }
  return points;
}

/// Integers so small that a third and more of all determinants are zero, on a grid of any spacing.
template <class Points>
Points smallIntegers(Random& random) {
  const int exponent = integer(random, 0, 2) == 0 ? -1074 : integer(random, -300, 200);
  Points points;
  for (auto& point : points)
    for (double& x : point) x = std::ldexp(integer(random, -1, 1), exponent);
  return points;
}

/// Coordinates of all magnitudes in a plane through an edge of the axes, and beside it by the least bit.
template <class Points>
Points diagonal(Random& random, int low, int high) {
  Points points;
  for (auto& point : points) {
    for (double& x : point) x = anyNumber(random, low, high);
    point.back() = point.front();
  }
  const int axes = int(points[0].size()), first = integer(random, 0, axes - 1);
  const double factor = integer(random, 0, 1) == 0 ? -0.5 : 2.0;
  nudge(points, random);
  for (auto& point : points) {
    point.back() *= factor;
    std::swap(point[first], point[0]);
  }
  return points;
}

Vec3 vector(const std::array<double, 3>& p) {
  return {p[0], p[1], p[2]};
}
Vec2 vector(const std::array<double, 2>& p) {
  return {p[0], p[1]};
}

/// The function's sign, and that of its exact stage, for two orders of the points.
void compare(const Tetrad& t, int expected) {
  REQUIRE(sideOfPlane(vector(t[0]), vector(t[1]), vector(t[2]), vector(t[3])) == -expected);
  REQUIRE(sideOfPlane(vector(t[3]), vector(t[1]), vector(t[0]), vector(t[2])) == -expected);
  REQUIRE(predicates::exactSideOfPlane(t[1].data(), t[0].data(), t[2].data(), t[3].data()) == expected);
}
void compare(const Triad& t, int expected) {
  REQUIRE(turn(vector(t[0]), vector(t[1]), vector(t[2])) == expected);
  REQUIRE(turn(vector(t[2]), vector(t[1]), vector(t[0])) == -expected);
  REQUIRE(predicates::exactTurn(t[1].data(), t[2].data(), t[0].data()) == expected);
}

template <class Make>
void compareWithRationals(int count, unsigned seed, Make&& make) {
  Random random(seed);
  int signs[3] = {0, 0, 0};
  for (int i = 0; i < count; ++i) {
    const auto points = make(random);
    const int expected = test::exactOrientation(points);
    ++signs[expected + 1];
    compare(points, expected);
  }
  for (const int found : signs) REQUIRE(found > count / 100);
}

/// @param times 1: half a second
void compareWithRationals(int times) {
  const int few = 2'000 * times, many = 20'000 * times;
  for (unsigned seed : {1u, 2u}) {
    compareWithRationals(many, seed, inAPlane<Tetrad>);
    compareWithRationals(many, seed, inAPlane<Triad>);
    compareWithRationals(many, seed, turnedGrid<Tetrad>);
    compareWithRationals(many, seed, turnedGrid<Triad>);
    compareWithRationals(many, seed, smallIntegers<Tetrad>);
    compareWithRationals(many, seed, smallIntegers<Triad>);
    // Integers of 1 word, 1 and 2, 2 and 4; 2^-1074 to 1e90.
    for (const int range : {4, 10, 70, 100}) {
      compareWithRationals(few, seed, [&](Random& r) { return diagonal<Tetrad>(r, -range / 2, range / 2); });
      compareWithRationals(few, seed, [&](Random& r) { return diagonal<Triad>(r, -range / 2, range / 2); });
    }
    compareWithRationals(few, seed, [](Random& r) { return diagonal<Tetrad>(r, -1060, 297); });
    compareWithRationals(few, seed, [](Random& r) { return diagonal<Triad>(r, -1060, 297); });
  }
}

}  // namespace

TEST_CASE("sideOfPlane is positive on the outer side of a triangle", "[exact]") {
  REQUIRE(sideOfPlane({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, 1e-80}) == 1);
  REQUIRE(sideOfPlane({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, -1e-80}) == -1);
  REQUIRE(sideOfPlane({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {7, -3, 0}) == 0);
  REQUIRE(sideOfPlane({1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {7, -3, 0}) == 0);
}

TEST_CASE("turn agrees with GMP around a line, bit by bit", "[exact]") {
  // The grid of L. Kettner et al., "Classroom examples of robustness problems in geometric computations"
  // (2008).
  const double ulp = std::ldexp(1.0, -53);
  for (int i = 0; i < 128; ++i)
    for (int j = 0; j < 128; ++j) {
      const Triad t = {{{0.5 + i * ulp, 0.5 + j * ulp}, {12.0, 12.0}, {24.0, 24.0}}};
      compare(t, test::exactOrientation(t));
    }
  REQUIRE(turn({0, 0}, {1, 0}, {0, 1}) == 1);
}

TEST_CASE("sideOfPlane and turn agree with GMP in and near planes and lines, at all magnitudes", "[exact]") {
  compareWithRationals(1);
}

TEST_CASE("sideOfPlane and turn agree with GMP in hundreds of millions of cases", "[.][exact-long]") {
  compareWithRationals(1000);
}

TEST_CASE("The exact stage has room for all doubles", "[exact]") {
  Random random(5);
  int signs[3] = {0, 0, 0};
  for (int i = 0; i < 20000; ++i) {
    const Tetrad t = diagonal<Tetrad>(random, -1060, 1019);
    const int expected = test::exactOrientation(t);
    ++signs[expected + 1];
    REQUIRE(predicates::exactSideOfPlane(t[0].data(), t[1].data(), t[2].data(), t[3].data()) == -expected);
  }
  for (const int count : signs) REQUIRE(count > 1000);
}
