// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/triangle_pair.h"
#include "tests/packMesh/mesh/integer_oracle.h"
#include "tests/packMesh/mesh/test_meshes.h"
#include "tests/support/catch.h"

using namespace packmesh;
using test::IntegerPoint;

namespace {

using IntegerTriangle = std::array<IntegerPoint, 3>;
using RealTriangle = std::array<Vec3, 3>;

bool meet(const RealTriangle& a, const RealTriangle& b) {
  return trianglesMeet(a[0], a[1], a[2], b[0], b[1], b[2]);
}

/// The verdict, which must not depend on the order of triangles or corners.
bool meetInAnyOrder(const RealTriangle& a, const RealTriangle& b) {
  const bool verdict = meet(a, b);
  REQUIRE(meet(b, a) == verdict);
  REQUIRE(meet({a[1], a[2], a[0]}, {b[1], b[0], b[2]}) == verdict);
  REQUIRE(meet({b[2], b[1], b[0]}, {a[2], a[0], a[1]}) == verdict);
  return verdict;
}

template <class Make>
void compareWithIntegers(int count, Make&& make) {
  int verdicts[2] = {0, 0};
  for (int i = 0; i < count; ++i) {
    const auto [a, b, scale] = make();
    const auto real = [s = scale](const IntegerTriangle& t) {
      RealTriangle out;
      for (int k = 0; k < 3; ++k) out[k] = s * Vec3(t[k][0], t[k][1], t[k][2]);
      return out;
    };
    const bool expected = test::trianglesMeet(a, b);
    ++verdicts[expected];
    REQUIRE(meetInAnyOrder(real(a), real(b)) == expected);
  }
  REQUIRE(verdicts[0] > count / 20);
  REQUIRE(verdicts[1] > count / 20);
}

struct Case {
  IntegerTriangle a, b;
  double scale;
};

}  // namespace

TEST_CASE("Intersections are exact for every kind of contact and degeneracy on a small grid", "[exact]") {
  std::mt19937 random(1);
  for (int size : {2, 3, 5})
    for (int thickness : {1, 2, size}) {  // 1: all in one plane
      compareWithIntegers(8000, [&] {
        Case c;
        for (IntegerTriangle* t : {&c.a, &c.b})
          for (IntegerPoint& p : *t)
            p = {long(random() % size), long(random() % size), long(random() % thickness)};
        c.scale = 1.0;
        return c;
      });
    }
}

TEST_CASE("Contacts in oblique distant planes are exact to one unit in the last place", "[exact]") {
  std::mt19937 random(2);
  std::uniform_int_distribution<long> entry(-(1L << 20), 1L << 20), far(-(1L << 25), 1L << 25);
  for (int perturbed : {0, 1})
    compareWithIntegers(20000, [&, perturbed] {
      long matrix[3][3], shift[3];
      for (int k = 0; k < 3; ++k) {
        shift[k] = far(random);
        for (long& m : matrix[k]) m = entry(random);
      }
      Case c;
      for (IntegerTriangle* t : {&c.a, &c.b})
        for (IntegerPoint& p : *t) {
          const long u = random() % 3, v = random() % 3, w = random() % 2;
          for (int k = 0; k < 3; ++k)
            p[k] = shift[k] + matrix[k][0] * u + matrix[k][1] * v + matrix[k][2] * w;
        }
      if (perturbed) (random() % 2 ? c.a : c.b)[random() % 3][random() % 3] += random() % 2 ? 1 : -1;
      c.scale = std::ldexp(1.0, -30);
      return c;
    });
}

TEST_CASE("Contacts broken by less than the rounding errors of determinants are not contacts", "[exact]") {
  // Small integers times 2^46, one coordinate moved by one: determinants far below what plain floating point
  // can tell from zero. Times 2^22, which the oracle can take, the verdicts are the same: determinants are
  // linear in a single coordinate, and coefficients are below 2^16.
  std::mt19937 random(4);
  std::uniform_int_distribution<long> entry(-7, 7);
  int verdicts[2] = {0, 0};
  for (int i = 0; i < 30000; ++i) {
    long matrix[3][3];
    for (auto& row : matrix)
      for (long& m : row) m = entry(random);
    if (i % 2)  // all in one plane
      for (long& m : matrix[random() % 3]) m = 0;
    std::array<IntegerTriangle, 2> exact;
    std::array<RealTriangle, 2> real;
    const unsigned moved = random() % 18;
    const long by = random() % 2 ? 1 : -1;
    for (unsigned t = 0; t < 2; ++t)
      for (unsigned c = 0; c < 3; ++c) {
        const long u = random() % 3, v = random() % 3, w = random() % 2;
        for (unsigned k = 0; k < 3; ++k) {
          const long base = matrix[k][0] * u + matrix[k][1] * v + matrix[k][2] * w;
          const long beside = moved == 9 * t + 3 * c + k ? by : 0;
          exact[t][c][k] = base * (1L << 22) + beside;
          real[t][c][k] = double(base * (1L << 46) + beside);
        }
      }
    const bool expected = test::trianglesMeet(exact[0], exact[1]);
    ++verdicts[expected];
    REQUIRE(meetInAnyOrder(real[0], real[1]) == expected);
  }
  REQUIRE(verdicts[0] > 5000);
  REQUIRE(verdicts[1] > 5000);
}

TEST_CASE("Triangles in general position agree with integer arithmetic", "[exact]") {
  std::mt19937 random(3);
  std::uniform_int_distribution<long> coordinate(-(1L << 22), 1L << 22);
  compareWithIntegers(20000, [&] {
    Case c;
    for (IntegerTriangle* t : {&c.a, &c.b})
      for (IntegerPoint& p : *t) p = {coordinate(random), coordinate(random), coordinate(random)};
    c.scale = 1e-6;  // rounds, but far less than what decides
    return c;
  });
}

TEST_CASE("A gap of one bit is a gap and a contact is a contact at any position", "[exact]") {
  const double up = std::numeric_limits<double>::infinity();
  for (double z : {1.0, 0.1, 12345.678, 99999.9}) {
    const RealTriangle floor = {Vec3(0, 0, z), Vec3(3, 0, z), Vec3(0, 3, z)};
    const auto standing = [](double lowest) {
      return RealTriangle{Vec3(1, 1, lowest), Vec3(1, 2, lowest + 1), Vec3(2, 1, lowest + 1)};
    };
    const auto lying = [](double height) {
      return RealTriangle{Vec3(0.5, 0.5, height), Vec3(1, 0.5, height), Vec3(0.5, 1, height)};
    };
    REQUIRE(meetInAnyOrder(floor, standing(z)));
    REQUIRE_FALSE(meetInAnyOrder(floor, standing(std::nextafter(z, up))));
    REQUIRE(meetInAnyOrder(floor, standing(std::nextafter(z, -up))));
    REQUIRE_FALSE(meetInAnyOrder(floor, standing(z + 1e-11 * z)));
    REQUIRE(meetInAnyOrder(floor, lying(z)));
    REQUIRE_FALSE(meetInAnyOrder(floor, lying(std::nextafter(z, up))));
    REQUIRE_FALSE(meetInAnyOrder(floor, lying(std::nextafter(z, -up))));
  }
}

TEST_CASE("Degenerate triangles are handled exactly", "[exact]") {
  const RealTriangle face = {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)};
  const auto point = [](const Vec3& p) { return RealTriangle{p, p, p}; };
  const auto segment = [](const Vec3& p, const Vec3& q) { return RealTriangle{p, q, (p + q) / 2}; };
  REQUIRE(meetInAnyOrder(face, point({1, 1, 0})));
  REQUIRE(meetInAnyOrder(face, point({2, 2, 0})));
  REQUIRE(meetInAnyOrder(face, point({4, 0, 0})));
  REQUIRE_FALSE(meetInAnyOrder(face, point({2.5, 2, 0})));
  REQUIRE_FALSE(meetInAnyOrder(face, point({1, 1, 1e-300})));
  REQUIRE(meetInAnyOrder(point({1, 2, 3}), point({1, 2, 3})));
  REQUIRE_FALSE(meetInAnyOrder(point({1, 2, 3}), point({1, 2, 4})));
  REQUIRE(meetInAnyOrder(face, segment({1, 1, -1}, {1, 1, 1})));
  REQUIRE_FALSE(meetInAnyOrder(face, segment({3, 3, -1}, {3, 3, 1})));
  REQUIRE(meetInAnyOrder(face, segment({-1, 1, 0}, {5, 1, 0})));
  REQUIRE_FALSE(meetInAnyOrder(face, segment({-1, 5, 0}, {5, 5, 0})));
  REQUIRE(meetInAnyOrder(segment({0, 0, 0}, {2, 2, 2}), segment({1, 1, 1}, {5, 5, 5})));
  REQUIRE_FALSE(meetInAnyOrder(segment({0, 0, 0}, {2, 2, 2}), segment({3, 3, 3}, {5, 5, 5})));
  REQUIRE(meetInAnyOrder(segment({0, 0, 0}, {2, 2, 2}), segment({2, 0, 0}, {0, 2, 2})));
}

TEST_CASE("A crossing segment is distinguished from a touching one", "[exact]") {
  const Vec3 a(0, 0, 0), b(4, 0, 0), c(0, 4, 0);
  REQUIRE(segmentCrossesTriangle({1, 1, -1}, {1, 1, 1}, a, b, c));
  REQUIRE_FALSE(segmentCrossesTriangle({1, 0, -1}, {1, 0, 1}, a, b, c));
  REQUIRE(segmentMeetsTriangle({1, 0, -1}, {1, 0, 1}, a, b, c));
  REQUIRE_FALSE(segmentCrossesTriangle({1, 1, 0}, {1, 1, 1}, a, b, c));
  REQUIRE(segmentMeetsTriangle({1, 1, 0}, {1, 1, 1}, a, b, c));
  REQUIRE_FALSE(segmentMeetsTriangle({1, -1e-300, -1}, {1, -1e-300, 1}, a, b, c));
}
