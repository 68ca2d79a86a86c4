// SPDX-License-Identifier: AGPL-3.0-or-later
#include <gmpxx.h>

#include "packMesh/mesh/predicates.h"
#include "packMesh/mesh/self_intersection.h"
#include "tests/packMesh/mesh/test_meshes.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

using Point = std::array<mpq_class, 3>;

Point pointOf(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

Point minus(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

mpq_class dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The ends of the part of the segment pq that is in a triangle with area, in rational numbers.
std::vector<Point> clipped(const Point& p, const Point& q, const std::array<Point, 3>& triangle) {
  const Point normal = cross(minus(triangle[1], triangle[0]), minus(triangle[2], triangle[0]));
  mpq_class from = 0, to = 1;
  // Keeps where f >= 0, for f from f(p) to f(q).
  const auto keep = [&](const mpq_class& atP, const mpq_class& atQ) {
    if (atP < 0 && atQ < 0) return false;
    if ((atP < 0) == (atQ < 0)) return true;
    const mpq_class t = atP / (atP - atQ);
    if (atP < 0 && t > from) from = t;
    if (atQ < 0 && t < to) to = t;
    return true;
  };
  const mpq_class aboveP = dot(normal, minus(p, triangle[0])), aboveQ = dot(normal, minus(q, triangle[0]));
  if (!keep(aboveP, aboveQ) || !keep(-aboveP, -aboveQ)) return {};
  for (int k = 0; k < 3; ++k) {
    const Point inward = cross(normal, minus(triangle[(k + 1) % 3], triangle[k]));
    if (!keep(dot(inward, minus(p, triangle[k])), dot(inward, minus(q, triangle[k])))) return {};
  }
  if (from > to) return {};
  std::vector<Point> ends(2);
  for (int k = 0; k < 3; ++k) {
    ends[0][k] = p[k] + from * (q[k] - p[k]);
    ends[1][k] = p[k] + to * (q[k] - p[k]);
  }
  return ends;
}

/// The extreme points of the intersection of two triangles are on edges: is any beyond what they share?
bool meetByRationals(const std::vector<Vec3>& vertices, const Triangle& s, const Triangle& t) {
  std::vector<Point> shared;
  for (const int v : s)
    if (v == t[0] || v == t[1] || v == t[2]) shared.push_back(pointOf(vertices[v]));
  const auto isShared = [&](const Point& x) {
    if (shared.empty()) return false;
    if (shared.size() == 1) return x == shared[0];
    const Point across = cross(minus(x, shared[0]), minus(shared[1], shared[0]));
    return across == Point{0, 0, 0};
  };
  const auto corners = [&](const Triangle& u) {
    return std::array<Point, 3>{pointOf(vertices[u[0]]), pointOf(vertices[u[1]]), pointOf(vertices[u[2]])};
  };
  const std::array<Point, 3> a = corners(s), b = corners(t);
  for (int k = 0; k < 3; ++k)
    for (const auto& ends : {clipped(a[k], a[(k + 1) % 3], b), clipped(b[k], b[(k + 1) % 3], a)})
      for (const Point& end : ends)
        if (!isShared(end)) return true;
  return false;
}

bool hasArea(const std::vector<Vec3>& v, const Triangle& t) {
  return axisShowing(v[t[0]], v[t[1]], v[t[2]]) >= 0;
}

}  // namespace

TEST_CASE("Self-intersections of crumpled meshes agree with rational numbers", "[exact][long]") {
  std::mt19937 random(11);
  const TriangleMesh sphere = test::icosphere(1);
  const SelfIntersectionFinder finder(sphere);
  int crossed = 0, plain = 0, pairs = 0;
  for (int n = 0; n < 60; ++n) {
    // On a coarse grid points, edges and planes coincide; without one they nearly do.
    const double amplitude = 0.03 * (n % 20), grid = n % 3 == 0 ? 0.0 : n % 3 == 1 ? 0.25 : 0.125;
    std::uniform_real_distribution<double> moved(-amplitude, amplitude);
    TriangleMesh mesh = sphere;
    for (Vec3& v : mesh.vertices) {
      v += Vec3(moved(random), moved(random), moved(random));
      if (grid > 0.0) v = (v / grid).array().round() * grid;
    }
    bool expected = false;
    const int count = int(mesh.triangles.size());
    for (int s = 0; s < count; ++s) {
      const Triangle& a = mesh.triangles[s];
      if (!hasArea(mesh.vertices, a)) expected = true;
      Box box;
      for (const int v : a) box.add(mesh.vertices[v]);
      for (int t = s + 1; t < count && hasArea(mesh.vertices, a); ++t) {
        const Triangle& b = mesh.triangles[t];
        Box other;
        for (const int v : b) other.add(mesh.vertices[v]);
        if (!box.meets(other) || !hasArea(mesh.vertices, b)) continue;
        const bool meets = meetByRationals(mesh.vertices, a, b);
        REQUIRE(meetBeyondShared(mesh.vertices, a, b) == meets);
        expected = expected || meets;
        ++pairs;
      }
    }
    CAPTURE(n);
    const auto found = finder(mesh.vertices);
    REQUIRE(found.has_value() == expected);
    REQUIRE(findSelfIntersection(mesh).has_value() == expected);
    if (found && found->first != found->second)
      CHECK(meetByRationals(mesh.vertices, mesh.triangles[found->first], mesh.triangles[found->second]));
    ++(expected ? crossed : plain);
  }
  CHECK(crossed > 15);
  CHECK(plain > 5);
  CHECK(pairs > 20000);
}

TEST_CASE("A fold, a spike and a turn too many around a vertex are self-intersections", "[exact]") {
  const TriangleMesh cell = test::redCell(3);
  const SelfIntersectionFinder finder(cell);
  CHECK_FALSE(finder(cell.vertices));
  std::vector<Vec3> vertices = cell.vertices;
  vertices[0] = -2.0 * vertices[0];  // through the cell
  CHECK(finder(vertices));
  // Two triangles of an octahedron onto each other, and not quite.
  TriangleMesh eight;
  eight.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  eight.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  const SelfIntersectionFinder ofEight(eight);
  CHECK_FALSE(ofEight(eight.vertices));
  vertices = eight.vertices;
  vertices[4] = Vec3(0, 0, -1);
  CHECK(ofEight(vertices));
  vertices[4] = Vec3(0, 0, -0.875);
  CHECK_FALSE(ofEight(vertices));
  // Five triangles around an apex, which go around it twice, as the star {5/2} does.
  TriangleMesh star;
  for (int k = 0; k < 5; ++k)
    star.vertices.push_back({std::cos(0.8 * M_PI * k), std::sin(0.8 * M_PI * k), 0.1 * k});
  star.vertices.push_back({0, 0, 1});
  star.vertices.push_back({0, 0, -2});
  for (int k = 0; k < 5; ++k) {
    star.triangles.push_back({k, (k + 1) % 5, 5});
    star.triangles.push_back({(k + 1) % 5, k, 6});
  }
  CHECK(SelfIntersectionFinder(star)(star.vertices));
}
