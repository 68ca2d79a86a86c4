// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/vessel.h"

#include "packMesh/container/primitives.h"
#include "packMesh/core/error.h"
#include "packMesh/mesh/closest_point.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/mesh_repair.h"
#include "packMesh/mesh/triangle_pair.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/support/catch.h"

using namespace packmesh;
using sample::moved;

namespace {

TriangleMesh cellAt(const Vec3& p, double radius = 1.0) {
  return sample::sphere(p, radius, 8, 10);
}

std::string verdict(const Wall& wall, const TriangleMesh& cell) {
  return wall.violation(cell).value_or("none");
}

/// One inlet of 4 x 4 at x = 0 that forks into two outlets of 2 x 4 at x = 10; y in [-1, 7], z in [0, 4].
TriangleMesh fork() {
  return moved(sample::voxels(10, 1.0,
                              [](int i, int j, int k) {
                                if (k >= 4) return false;
                                return i < 4 ? j >= 2 && j < 6 : i < 6 ? j < 8 : j < 2 || (j >= 6 && j < 8);
                              }),
               {0, -1, 0});
}

TriangleMesh swaying(double x0, double x1) {
  return sample::tube(
      x0, x1, 1 + int(2 * (x1 - x0)), 24,
      [](double x) { return Vec3(x, 3.0 * std::sin(2.0 * M_PI * x / 30.0), 0.0); },
      [](double x) { return 4.0 + std::cos(2.0 * M_PI * x / 30.0); });
}

void checkClosed(const Container& vessel) {
  TriangleMesh mesh = vessel.surface();
  REQUIRE(repairClosed(mesh, "surface").empty());
}

}  // namespace

TEST_CASE("A vessel made of a tube equals a cylinder", "[container][long]") {
  const TriangleMesh tube = sample::straightTube(0.0, 20.0, 5.0, 21, 200);
  for (const bool periodic : {false, true})
    for (const double beyond : {0.0, 0.75, -1.5}) {
      const VesselEnds ends{0, -beyond, 20.0 + beyond, periodic};
      const auto vessel = makeVessel(tube, ends, 0.25);
      const auto cylinder = makeCylinder({10, 0, 0}, 0, 5.0, 20.0 + 2.0 * beyond, periodic);
      checkClosed(*vessel);
      REQUIRE(vessel->period().isApprox(cylinder->period()));
      REQUIRE(vessel->bounds().lo.isApprox(cylinder->bounds().lo, 1e-3));
      REQUIRE(vessel->bounds().hi.isApprox(cylinder->bounds().hi, 1e-3));
      REQUIRE(vessel->volume() ==
              Approx(M_PI * 25.0 * (periodic ? 20.0 + 2.0 * beyond : 20.0)).epsilon(1e-3));
      std::mt19937 random(4);
      std::uniform_real_distribution<double> x(-6.0, 26.0), y(-6.0, 6.0);
      for (int n = 0; n < 1000; ++n) {
        const Vec3 p(x(random), y(random), y(random));
        const WallDistance found = vessel->wall()->distance(p), expected = cylinder->wall()->distance(p);
        REQUIRE(found.distance <= expected.distance + vessel->wall()->slack() + 1e-9);
        if (std::abs(expected.distance) > 1.0) {
          REQUIRE(found.distance * expected.distance > 0.0);
          continue;
        }
        REQUIRE(found.distance == Approx(expected.distance).margin(0.01));
        const double radial = 5.0 - p.tail<2>().norm(),
                     axial = std::min(p.x() + beyond, 20.0 + beyond - p.x());
        if (periodic || std::abs(radial - axial) > 0.02)
          REQUIRE((found.gradient - expected.gradient).norm() < 0.06);
      }
      for (int n = 0; n < 150; ++n) {
        const TriangleMesh cell = cellAt({x(random), 0.8 * y(random), 0.8 * y(random)});
        const auto found = vessel->wall()->violation(cell), expected = cylinder->wall()->violation(cell);
        double margin = 1.0;  // of the outermost vertex
        for (const Vec3& v : cell.vertices) margin = std::min(margin, std::abs(5.0 - v.tail<2>().norm()));
        if (margin > 0.002) REQUIRE(found.has_value() == expected.has_value());
      }
    }
}

TEST_CASE("A vessel without ends is its mesh, including holes", "[container]") {
  TriangleMesh mesh = sample::sphere({0, 0, 0}, 8.0, 24, 30);
  sample::append(mesh, sample::sphere({2, 0, 0}, 1.5, 12, 16));
  repairClosed(mesh, "vessel");
  const auto vessel = makeVessel(mesh, std::nullopt, 0.2);
  REQUIRE(vessel->volume() == Approx(signedVolume(mesh)));
  REQUIRE(vessel->period() == Vec3::Zero());
  const Wall& wall = *vessel->wall();
  REQUIRE(wall.distance({2, 0, 0}).distance < 0.0);
  REQUIRE(wall.distance({-2, 0, 0}).distance == Approx(2.5).margin(0.1));
  REQUIRE(wall.distance({9, 0, 0}).distance == Approx(-1.0).margin(0.1));
  REQUIRE_FALSE(wall.violation(cellAt({-3, 0, 0})));
  REQUIRE(verdict(wall, cellAt({-7, 0, 0}, 2.0)) == "meets the wall");
  REQUIRE(verdict(wall, cellAt({3.5, 0, 0}, 0.7)) == "meets the wall");
  REQUIRE(verdict(wall, cellAt({2, 0, 0}, 1.0)) == "is outside the lumen");
  REQUIRE(verdict(wall, cellAt({20, 0, 0}, 1.0)) == "is outside the lumen");
  REQUIRE(verdict(wall, cellAt({2, 0, 0}, 3.0)) == "encloses part of the wall");
  REQUIRE(verdict(wall, cellAt({0, 0, 0}, 20.0)) == "is outside the lumen");
  // A cell of two parts, of which one is elsewhere.
  TriangleMesh two = cellAt({-3, 0, 0});
  sample::append(two, cellAt({-20, 0, 0}));
  REQUIRE(wall.violation(two));
}

TEST_CASE("Touching the wall of a vessel counts as meeting it, exactly", "[container]") {
  const auto vessel = makeVessel(sample::box({0, 0, 0}, {10, 10, 10}), VesselEnds{0, 0.0, 10.0, true}, 0.5);
  REQUIRE(vessel->wall()->violation(sample::box({2, 0, 3}, {3, 1, 4})));
  REQUIRE_FALSE(vessel->wall()->violation(sample::box({2, 1e-300, 3}, {3, 1, 4})));
  REQUIRE_FALSE(vessel->wall()->violation(sample::box({-2, 1e-12, 3}, {3, 1, 4})));
  REQUIRE(vessel->wall()->violation(sample::box({-2, 0, 3}, {3, 1, 4})));
  REQUIRE_FALSE(vessel->wall()->violation(sample::box({1002, 0.1, 3}, {1013, 1, 4})));
  REQUIRE(vessel->wall()->violation(sample::box({1002, 0, 3}, {1013, 1, 4})));
  const auto closed = makeVessel(sample::box({0, 0, 0}, {10, 10, 10}), VesselEnds{0, 0.0, 10.0, false}, 0.5);
  REQUIRE(verdict(*closed->wall(), sample::box({0, 1, 3}, {3, 2, 4})) == "meets an end of the vessel");
  REQUIRE_FALSE(closed->wall()->violation(sample::box({1e-300, 1, 3}, {3, 2, 4})));
}

TEST_CASE("A curved periodic vessel is continued by its own image", "[container]") {
  const TriangleMesh tube = swaying(0.0, 30.0);
  const auto vessel = makeVessel(tube, VesselEnds{0, 0.0, 30.0, true}, 0.2);
  checkClosed(*vessel);
  // Three periods in one mesh say what is true.
  const TriangleMesh longer = swaying(-30.0, 60.0);
  const ClosestPoint truth(longer);
  const auto whole = makeVessel(longer, std::nullopt, 1.0);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> x(-4.0, 34.0), y(-8.0, 8.0);
  for (int n = 0; n < 3000; ++n) {
    const Vec3 p(x(random), y(random), y(random));
    const double expected = -truth.signedDistance(p), found = vessel->wall()->distance(p).distance;
    REQUIRE(found <= expected + vessel->wall()->slack() + 1e-9);
    if (std::abs(expected) < 1.0) REQUIRE(found == Approx(expected).margin(0.04));
  }
  int inside = 0;
  for (int n = 0; n < 500; ++n) {
    const TriangleMesh cell = cellAt({x(random), 0.7 * y(random), 0.5 * y(random)}, 1.5);
    const bool found = vessel->wall()->violation(cell).has_value();
    REQUIRE(found == whole->wall()->violation(cell).has_value());
    REQUIRE(found == vessel->wall()->violation(moved(cell, {60.0, 0.0, 0.0})).has_value());
    inside += !found;
  }
  REQUIRE(inside > 50);
}

TEST_CASE("The gap to a vessel's wall is that of the nearest two triangles, images and ends included",
          "[container]") {
  const double period = 30.0;
  const TriangleMesh tube = swaying(0.0, period);
  const MeshHierarchy cell(cellAt(Vec3::Zero(), 1.5));
  for (const bool periodic : {true, false}) {
    const auto vessel = makeVessel(tube, VesselEnds{0, 0.0, period, periodic}, 0.3);
    const auto asMesh = openVessel(tube, 0);  // the wall without its caps
    std::mt19937 random(17);
    std::uniform_real_distribution<double> x(-1.0, 31.0), y(-2.2, 2.2);
    int measured = 0, notBelow = 0, atEnds = 0, throughEnds = 0;
    for (int n = 0; n < 150; ++n) {
      const double along = x(random);
      const Vec3 at(along, 3.0 * std::sin(2.0 * M_PI * along / period) + y(random), y(random));
      const Placement placement{Mat3::Identity(), at};
      constexpr double interest = 0.7;
      const WallVerdict verdict = vessel->wall()->examine({cell, placement}, interest);
      if (verdict.violation) continue;
      const TriangleMesh there = placed(cell.mesh(), placement);
      const Box near = boundingBox(there).grownBy(interest);  // gaps to anything beyond do not matter
      double expected = std::numeric_limits<double>::infinity(), own = expected;
      for (const double shift : {-period, 0.0, period}) {
        if (!periodic && shift != 0.0) continue;
        for (std::size_t w = 0; w < asMesh.mesh.triangles.size(); ++w) {
          const auto corner = [&](int k) {
            return Vec3(asMesh.mesh.corner(int(w), k) + shift * Vec3::UnitX());
          };
          Box box;
          for (int k = 0; k < 3; ++k) box.add(corner(k));
          if (!box.meets(near)) continue;
          for (std::size_t t = 0; t < there.triangles.size(); ++t) {
            const double gap = triangleDistance(corner(0), corner(1), corner(2), there.corner(int(t), 0),
                                                there.corner(int(t), 1), there.corner(int(t), 2));
            expected = std::min(expected, gap);
            if (shift == 0.0) own = std::min(own, gap);
          }
        }
      }
      throughEnds += expected < interest && expected < own;
      if (!periodic) {
        const Box box = boundingBox(there);
        const double toEnds = std::min(box.lo.x(), period - box.hi.x());
        atEnds += toEnds < std::min(expected, interest);
        expected = std::min(expected, toEnds);
      }
      if (expected < interest)
        REQUIRE(verdict.gap == Approx(expected).margin(1e-9));
      else
        REQUIRE(verdict.gap == std::numeric_limits<double>::infinity());
      ++(expected < interest ? measured : notBelow);
      if (vessel->wall()->isAway(boundingSphere(cell, placement), interest)) REQUIRE(expected > interest);
    }
    REQUIRE(measured > 20);
    REQUIRE(notBelow > 10);
    REQUIRE((periodic ? throughEnds : atEnds) > 0);
  }
}

TEST_CASE("A vessel can have several flat outlets in one plane", "[container]") {
  const auto vessel = makeVessel(fork(), VesselEnds{0, -1.0, 12.0, false}, 0.25);
  checkClosed(*vessel);
  REQUIRE(vessel->volume() == Approx(signedVolume(fork())));
  const Wall& wall = *vessel->wall();
  REQUIRE(wall.distance({11.0, 0.0, 2.0}).distance == Approx(1.0).margin(0.15));
  REQUIRE(wall.distance({11.0, 6.0, 2.0}).distance == Approx(1.0).margin(0.15));
  REQUIRE(wall.distance({11.0, 3.0, 2.0}).distance == Approx(-2.0).margin(0.15));
  REQUIRE(wall.distance({-0.5, 3.0, 2.0}).distance == Approx(0.5).margin(1e-6));
  REQUIRE(wall.distance({11.75, 0.0, 2.0}).distance == Approx(0.25).margin(1e-6));
  REQUIRE_FALSE(wall.violation(cellAt({10.0, 0.0, 2.0}, 0.9)));
  REQUIRE_FALSE(wall.violation(cellAt({10.0, 6.0, 2.0}, 0.9)));
  REQUIRE_FALSE(wall.violation(cellAt({0.0, 3.0, 2.0}, 0.9)));
  REQUIRE(verdict(wall, cellAt({8.0, 3.0, 2.0}, 0.9)) == "is outside the lumen");
  REQUIRE(verdict(wall, cellAt({10.0, 0.0, 2.0}, 1.1)) == "meets the wall");
  REQUIRE(verdict(wall, cellAt({11.5, 0.0, 2.0}, 0.9)) == "meets an end of the vessel");
  CHECK_THROWS_WITH(makeVessel(fork(), VesselEnds{0, 0.0, 10.0, true}, 0.5),
                    Contains("must have the same outline (x = 0 and 10 µm)"));
  // Periodic along z it is an extruded letter.
  const auto extruded = makeVessel(fork(), VesselEnds{2, -0.25, 4.25, true}, 0.25);
  checkClosed(*extruded);
  REQUIRE_FALSE(extruded->wall()->violation(cellAt({5.0, 3.0, 4.25}, 0.9)));
}

TEST_CASE("A periodic vessel can have any axis and different triangulations of the same outline",
          "[container]") {
  // A square tube along z whose ends have different vertices.
  std::vector<std::vector<Vec3>> rings(2);
  for (int k = 0; k < 8; ++k) {
    const double half = 3.0;
    const Vec3 corner[4] = {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}};
    const Vec3 a = corner[k / 2], b = corner[(k / 2 + 1) % 4];
    rings[0].push_back(k % 2 ? Vec3(0.5 * (a + b)) : a);
    rings[1].push_back((k % 2 ? Vec3(0.7 * a + 0.3 * b) : a) + Vec3(0, 0, 9));
  }
  const auto vessel = makeVessel(sample::sweep(rings), VesselEnds{2, 0.0, 9.0, true}, 0.25);
  REQUIRE(vessel->wall()->distance({2.5, 0.0, 0.1}).distance == Approx(0.5).margin(0.01));
  REQUIRE_FALSE(vessel->wall()->violation(cellAt({0.0, 0.0, 9.0}, 2.5)));
  REQUIRE(vessel->wall()->violation(cellAt({0.0, 1.0, 9.0}, 2.5)));
}

TEST_CASE("Errors of a vessel are reported", "[container][messages]") {
  const TriangleMesh tube = sample::straightTube(0.0, 20.0, 5.0, 11, 16);
  CHECK_THROWS_WITH(makeVessel({}, std::nullopt, 0.25), Contains("no triangles"));
  CHECK_THROWS_WITH(makeVessel(tube, std::nullopt, 0.0), Contains("spacing of the vessel's distances"));
  CHECK_THROWS_WITH(makeVessel(tube, VesselEnds{4, 0, 20, true}, 0.25), Contains("axis"));
  CHECK_THROWS_WITH(makeVessel(tube, VesselEnds{0, 20, 0, true}, 0.25),
                    Contains("end of the vessel must lie beyond its beginning"));
  CHECK_THROWS_WITH(makeVessel(tube, VesselEnds{0, 30, 40, true}, 0.25),
                    Contains("lies outside the container"));
  CHECK_THROWS_WITH(makeVessel(sample::sphere(Vec3::Zero(), 5.0, 10, 16), VesselEnds{0, -5, 5, false}, 0.25),
                    Contains("no flat end perpendicular to x at x = -"));
  const TriangleMesh cone = sample::tube(
      0.0, 20.0, 11, 16, [](double x) { return Vec3(x, 0, 0); }, [](double x) { return 5.0 - 0.1 * x; });
  CHECK_THROWS_WITH(
      makeVessel(cone, VesselEnds{0, -1, 21, true}, 0.25),
      Contains("must have the same outline (x = -1 and 21 µm)") && Contains("they differ by 2 µm"));
  CHECK_NOTHROW(makeVessel(cone, VesselEnds{0, -1, 21, false}, 0.5));
  const TriangleMesh shifted = sample::tube(
      0.0, 20.0, 11, 16, [](double x) { return Vec3(x, 0.01 * x, 0); }, [](double) { return 5.0; });
  CHECK_THROWS_WITH(makeVessel(shifted, VesselEnds{0, 0, 20, true}, 0.5), Contains("same outline"));
}

TEST_CASE("A vessel describes itself", "[container]") {
  for (const bool periodic : {true, false})
    CHECK(
        makeVessel(sample::straightTube(0.0, 20.0, 5.0, 11, 16), VesselEnds{0, -0.75, 20.75, periodic}, 0.25)
            ->describe() == std::string("vessel 21.5 x 10 x 10 µm of 416 triangles, ") +
                                (periodic ? "periodic along x" : "closed along x"));
}
