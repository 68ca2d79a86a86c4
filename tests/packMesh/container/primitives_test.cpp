// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/primitives.h"

#include "packMesh/core/error.h"
#include "packMesh/mesh/mesh_repair.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/support/catch.h"

using namespace packmesh;
using sample::moved;

namespace {

/// Gradient against finite differences, at random points in and around the container.
void checkGradient(const Container& container) {
  const Wall& wall = *container.wall();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const Box box = container.bounds().grownBy(2.0);
  const double step = 1e-6;
  int compared = 0;
  for (int n = 0; n < 1000; ++n) {
    const Vec3 p = box.lo + Vec3(unit(random), unit(random), unit(random)).cwiseProduct(box.size());
    const WallDistance here = wall.distance(p);
    REQUIRE(here.gradient.norm() == Approx(1.0));
    Vec3 slope;
    for (int k = 0; k < 3; ++k)
      slope[k] = (wall.distance(p + step * Vec3::Unit(k)).distance -
                  wall.distance(p - step * Vec3::Unit(k)).distance) /
                 (2.0 * step);
    if (std::abs(slope.norm() - 1.0) > 1e-3) continue;  // between two walls
    ++compared;
    REQUIRE((slope - here.gradient).norm() < 1e-4);
  }
  REQUIRE(compared > 950);
}

void checkSurface(const Container& container, double tolerance) {
  TriangleMesh mesh = container.surface();
  REQUIRE(repairClosed(mesh, "surface").empty());
  REQUIRE(signedVolume(mesh) == Approx(container.volume()).epsilon(tolerance));
  REQUIRE(signedVolume(mesh) >= container.volume() * (1.0 - 1e-12));
  REQUIRE(boundingBox(mesh).size().isApprox(container.bounds().size(), tolerance));
}

}  // namespace

TEST_CASE("A box has the right volume, distances, wall test and description", "[container]") {
  const Box box{{-1, 0, 2}, {9, 5, 6}};
  const auto closed = makeBox(box, {false, false, false});
  REQUIRE(closed->volume() == 200.0);
  REQUIRE(closed->period() == Vec3::Zero());
  REQUIRE(closed->bounds().lo == box.lo);
  REQUIRE(closed->describe() == "box 10 x 5 x 4 µm");
  REQUIRE(closed->wall()->distance({0, 2, 4}).distance == 1.0);
  REQUIRE(closed->wall()->distance({0, 2, 4}).gradient == Vec3(1, 0, 0));
  REQUIRE(closed->wall()->distance({4, 7, 4}).distance == -2.0);
  REQUIRE(closed->wall()->distance({4, 7, 4}).gradient == Vec3(0, -1, 0));
  REQUIRE(closed->wall()->slack() == 0.0);
  checkGradient(*closed);
  checkSurface(*closed, 1e-12);

  const auto periodic = makeBox(box, {true, true, true});
  REQUIRE(periodic->wall() == nullptr);
  REQUIRE(periodic->period() == Vec3(10, 5, 4));
  REQUIRE(periodic->describe() == "periodic box 10 x 5 x 4 µm");

  const auto slit = makeBox(box, {true, true, false});
  REQUIRE(slit->describe() == "box 10 x 5 x 4 µm, periodic along x and y");
  REQUIRE(slit->wall()->distance({99, -99, 2.5}).distance == 0.5);
  checkGradient(*slit);

  const TriangleMesh cell = sample::sphere({0, 0, 0}, 1.0, 6, 8);
  REQUIRE_FALSE(closed->wall()->violation(moved(cell, {4, 2, 4})));
  REQUIRE_FALSE(slit->wall()->violation(moved(cell, {99, 2, 4})));
  REQUIRE(closed->wall()->violation(moved(cell, {4, 2, 2.5})).value() == "meets the wall");
  REQUIRE(closed->wall()->violation(moved(cell, {4, 2, 3})).value() == "meets the wall");  // touches
  REQUIRE(closed->wall()->violation(moved(cell, {40, 2, 4})).value() == "is outside the lumen");
  const TriangleMesh touching = sample::box({-1, 1, 3}, {0, 2, 4}),
                     apart = sample::box({std::nextafter(-1.0, 0.0), 1, 3}, {0, 2, 4});
  REQUIRE(closed->wall()->violation(touching));
  REQUIRE_FALSE(closed->wall()->violation(apart));
}

TEST_CASE("A cylinder along any axis has the right volume, distances, wall test and description",
          "[container]") {
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 center(1, 2, 3);
    const auto closed = makeCylinder(center, axis, 5.0, 20.0, false),
               open = makeCylinder(center, axis, 5.0, 20.0, true);
    REQUIRE(closed->volume() == Approx(M_PI * 500.0));
    REQUIRE(open->period() == 20.0 * Vec3::Unit(axis));
    REQUIRE(open->bounds().size()[axis] == 20.0);
    REQUIRE(open->bounds().size()[(axis + 1) % 3] == 10.0);
    const Vec3 side = Vec3::Unit((axis + 1) % 3);
    REQUIRE(closed->wall()->distance(center + 4.0 * side).distance == Approx(1.0));
    REQUIRE(closed->wall()->distance(center + 4.0 * side).gradient.isApprox(-side));
    REQUIRE(closed->wall()->distance(center + 9.5 * Vec3::Unit(axis)).distance == Approx(0.5));
    REQUIRE(open->wall()->distance(center + 9.5 * Vec3::Unit(axis)).distance == Approx(5.0));
    REQUIRE(open->wall()->distance(center + 6.0 * side).distance == Approx(-1.0));
    checkGradient(*closed);
    checkGradient(*open);
    checkSurface(*closed, 0.003);
    const TriangleMesh cell = moved(sample::sphere({0, 0, 0}, 1.0, 6, 8), center);
    REQUIRE_FALSE(closed->wall()->violation(cell));
    REQUIRE_FALSE(open->wall()->violation(moved(cell, 9.5 * Vec3::Unit(axis))));
    REQUIRE(closed->wall()->violation(moved(cell, 9.5 * Vec3::Unit(axis))).value() == "meets the wall");
    REQUIRE(open->wall()->violation(moved(cell, 4.5 * side)).value() == "meets the wall");
    REQUIRE(open->wall()->violation(moved(cell, 7.0 * side)).value() == "is outside the lumen");
  }
  REQUIRE(makeCylinder({25, 13, 13}, 0, 12.5, 50, true)->describe() ==
          "cylinder along x, radius 12.5 µm, length 50 µm, periodic ends");
}

TEST_CASE("A sphere has the right volume, distances, wall test and description", "[container]") {
  const auto sphere = makeSphere({1, 2, 3}, 4.0);
  REQUIRE(sphere->volume() == Approx(4.0 / 3.0 * M_PI * 64.0));
  REQUIRE(sphere->describe() == "sphere, radius 4 µm");
  REQUIRE(sphere->wall()->distance({1, 2, 3}).distance == 4.0);
  REQUIRE(sphere->wall()->distance({1, 2, 6}).distance == Approx(1.0));
  checkGradient(*sphere);
  checkSurface(*sphere, 0.02);
  REQUIRE(sphere->surface().triangles.size() == 1280);
  const TriangleMesh cell = sample::sphere({1, 2, 3}, 1.0, 6, 8);
  REQUIRE_FALSE(sphere->wall()->violation(moved(cell, {2.9, 0, 0})));
  REQUIRE(sphere->wall()->violation(moved(cell, {0, 0, 3})).value() == "meets the wall");
  REQUIRE(sphere->wall()->violation(moved(cell, {8, 0, 0})).value() == "is outside the lumen");
}

TEST_CASE("The gap of a cell in a convex lumen is that of its nearest vertex", "[container]") {
  const MeshHierarchy cell(sample::box({-1, -1, -1}, {1, 1, 1}));
  const auto gapAt = [&](const Container& container, const Vec3& p, double interest) {
    const WallVerdict verdict = container.wall()->examine({cell, {Mat3::Identity(), p}}, interest);
    REQUIRE_FALSE(verdict.violation);
    return verdict.gap;
  };
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const auto box = makeBox({{0, 0, 0}, {10, 20, 30}}, {true, false, false});
  REQUIRE(gapAt(*box, {77, 1.25, 15}, 1.0) == 0.25);
  REQUIRE(gapAt(*box, {77, 10, 28.5}, 1.0) == 0.5);
  REQUIRE(gapAt(*box, {77, 1.25, 28.5}, 1.0) == 0.25);
  REQUIRE(gapAt(*box, {77, 1.25, 28.5}, 0.25) == infinite);
  REQUIRE(gapAt(*box, {77, 1.25, 28.5}, 0.0) == infinite);
  REQUIRE(gapAt(*box, {77, 10, 15}, 100.0) == 9.0);
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 side = Vec3::Unit((axis + 1) % 3), along = Vec3::Unit(axis);
    const auto open = makeCylinder({0, 0, 0}, axis, 5.0, 20.0, true),
               closed = makeCylinder({0, 0, 0}, axis, 5.0, 20.0, false);
    REQUIRE(gapAt(*open, 2.0 * side, 9.0) == Approx(5.0 - std::sqrt(10.0)).epsilon(1e-14));
    REQUIRE(gapAt(*open, 2.0 * side + 9.0 * along, 9.0) == Approx(5.0 - std::sqrt(10.0)).epsilon(1e-14));
    REQUIRE(gapAt(*closed, 2.0 * side + 8.5 * along, 9.0) == 0.5);
  }
  const auto sphere = makeSphere({0, 0, 0}, 6.0);
  REQUIRE(gapAt(*sphere, {3, 0, 0}, 9.0) == Approx(6.0 - std::sqrt(18.0)).epsilon(1e-14));
  REQUIRE(sphere->wall()->examine({cell, {Mat3::Identity(), {5, 0, 0}}}, 9.0).gap == infinite);
  REQUIRE(sphere->wall()->isAway({{3, 0, 0}, 1.5}, 1.49));
  REQUIRE_FALSE(sphere->wall()->isAway({{3, 0, 0}, 1.5}, 1.51));
}

TEST_CASE("Containers reject invalid sizes", "[container][messages]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(makeBox({{0, 0, 0}, {1, 0, 1}}, {false, false, false}),
                    Contains("along y must be positive and finite; found 0 µm"));
  CHECK_THROWS_AS(makeBox(Box(), {false, false, false}), InputError);
  CHECK_THROWS_AS(makeBox({{0, 0, nan}, {1, 1, 1}}, {true, true, true}), InputError);
  CHECK_THROWS_WITH(makeCylinder({0, 0, 0}, 0, -1.0, 2.0, true), Contains("radius of the cylinder"));
  CHECK_THROWS_WITH(makeCylinder({0, 0, 0}, 0, 1.0, nan, true), Contains("length of the cylinder"));
  CHECK_THROWS_WITH(makeCylinder({0, 0, 0}, 3, 1.0, 2.0, true), Contains("axis"));
  CHECK_THROWS_AS(makeCylinder({nan, 0, 0}, 0, 1.0, 2.0, true), InputError);
  CHECK_THROWS_WITH(makeSphere({0, 0, 0}, 0.0), Contains("radius of the sphere"));
  CHECK_THROWS_AS(makeSphere({0, 0, nan}, 1.0), InputError);
}
