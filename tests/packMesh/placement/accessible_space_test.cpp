// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/placement/accessible_space.h"

#include "packMesh/core/random.h"
#include "packMesh/placement/placement.h"
#include "tests/support/catch.h"
#include "tests/support/physics.h"
#include "tests/support/shapes.h"
#include "tests/support/vessels.h"

using namespace packmesh;

namespace {

std::shared_ptr<const Container> tube(double radius) {
  return makeVessel(
      sample::tube(
          0.0, 30.0, 31, 40, [](double) { return Vec3::Zero(); }, [=](double) { return radius; }),
      {}, 0.25);
}

bool meetsWall(const Physics& physics, const Pose& pose) {
  return physics.wallOf(0)
      ->examine({physics.shapes[0]->hierarchy(), pose.placement()}, 0.0)
      .violation.has_value();
}

}  // namespace

TEST_CASE("Points are in all of a lumen", "[placement]") {
  for (const auto& container : {tube(3.0), test::twoChambers()}) {
    const AccessibleSpace space(*container, {}, AccessibleSpace::Points::exact);
    CHECK(space.volume() == Approx(container->volume()).epsilon(0.03));
    CHECK(space.apart().size() == 1);
    for (int i = 0; i < 200; ++i) {
      const Vec3 u = evenPoint({0.1, 0.2, 0.3, 0.4}, i);
      const Vec3 p = space.pose(evenShare(0.0, i), {u[0], u[1], u[2], 0.0}, Quaternion::Identity()).position;
      CHECK(container->wall()->distance(p).distance > -0.7);
    }
  }
}

TEST_CASE("Larger boxes cover a lumen", "[placement]") {
  for (const auto& container : {tube(3.0), test::twoChambers()}) {
    const AccessibleSpace cover(*container, {}, AccessibleSpace::Points::covered);
    CHECK_FALSE(cover.complete());
    CHECK(cover.parts().size() <
          AccessibleSpace(*container, {}, AccessibleSpace::Points::exact).parts().size() / 2);
    const Box bounds = container->bounds();
    int inside = 0, tried = 0, found = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 p = bounds.lo + bounds.size().cwiseProduct(evenPoint({0.1, 0.2, 0.3, 0.4}, i));
      const Vec3 u = evenPoint({0.4, 0.3, 0.2, 0.1}, i);
      const Vec3 drawn =
          cover.pose(evenShare(0.0, i), {u[0], u[1], u[2], 0.0}, Quaternion::Identity()).position;
      ++tried;
      found += container->wall()->distance(drawn).distance > 0.0;
      if (container->wall()->distance(p).distance < 0.0) continue;
      ++inside;
      CHECK(std::any_of(cover.parts().begin(), cover.parts().end(), [&](const AccessibleSpace::Part& part) {
        return ((p - part.centre).cwiseAbs().array() <= 1.001 * part.half.cast<double>().array()).all();
      }));
    }
    CHECK(inside > 500);
    CHECK(double(found) / tried * cover.volume() == Approx(container->volume()).epsilon(0.02));
  }
}

TEST_CASE("A cell can be where it fits in some orientation", "[placement]") {
  const Physics physics = test::physicsOf({test::redCellShape()}, tube(6.0));
  const double radius = physics.shapes[0]->radius(), thin = physics.shapes[0]->bound().semiAxes.minCoeff();
  const AccessibleSpace space(physics, 0, {});
  // At least where any orientation fits, at most where a sphere as thick as the cell fits.
  CHECK(space.volume() > M_PI * std::pow(6.0 - radius, 2) * (30.0 - 2.0 * radius));
  CHECK(space.volume() < M_PI * std::pow(6.0 - thin, 2) * (30.0 - 2.0 * thin));
  CHECK(space.apart().size() == 1);
  int meeting = 0, wished = 0;
  constexpr int count = 400;
  double lo = 1e9, hi = -1e9;
  for (int i = 0; i < count; ++i) {
    const auto u = uniform4(1, RandomStream::position, i, 0),
               v = uniform4(1, RandomStream::orientation, i, 0);
    const Quaternion wish = uniformRotation(v[0], v[1], v[2]);
    const Pose pose = space.pose(evenShare(0.3, i), u, wish);
    meeting += meetsWall(physics, pose);
    wished += pose.orientation.coeffs() == wish.coeffs();
    lo = std::min(lo, pose.position.x());
    hi = std::max(hi, pose.position.x());
  }
  CHECK(meeting <=
        count / 3);  // the test is one of points and interpolated distances; placement then asks the wall
  CHECK(wished > count / 4);
  CHECK(lo < thin + 1.0);
  CHECK(hi > 29.0 - thin);
}

TEST_CASE("A red cell is in no tube narrower than itself, and its clearance counts", "[placement]") {
  Physics physics = test::physicsOf({test::redCellShape()}, tube(3.5));
  CHECK(AccessibleSpace(physics, 0, {}).volume() == 0.0);
  physics.container = tube(4.6);
  const double volume = AccessibleSpace(physics, 0, {}).volume();
  CHECK(volume > 0.0);
  physics.wallClearance = 0.5;
  CHECK(AccessibleSpace(physics, 0, {}).volume() < 0.8 * volume);
  physics.wallClearance = 1.0;
  CHECK(AccessibleSpace(physics, 0, {}).volume() == 0.0);
  CHECK(AccessibleSpaces(physics, {}).of(0) == nullptr);
}

TEST_CASE("Chambers between which no cell can pass are apart", "[placement]") {
  const Physics physics = test::physicsOf({test::redCellShape()}, test::twoChambers());
  const AccessibleSpace space(physics, 0, {});
  const std::vector<double> apart = space.apart();
  REQUIRE(apart.size() == 2);
  CHECK(apart[0] == Approx(0.5).margin(0.05));
  for (const AccessibleSpace::Part& part : space.parts()) CHECK(std::abs(part.centre.x()) > 1.0);
  int left = 0;
  constexpr int count = 100;
  for (const Pose& pose : placeRandomly(physics, {}, 0, 0, 0, count, &space)) {
    CHECK_FALSE(meetsWall(physics, pose));
    left += pose.position.x() < 0.0;
  }
  CHECK(left == Approx(count / 2).margin(10));
}

TEST_CASE("In a lumen too large for its space, cells begin where they may fit", "[placement]") {
  const Physics physics = test::physicsOf({test::redCellShape()}, tube(6.0));
  const AccessibleSpace space(physics, 0, Threads(2), 100);
  REQUIRE_FALSE(space.complete());
  for (const Pose& pose : placeRandomly(physics, {}, 0, 0, 0, 200, &space))
    CHECK_FALSE(meetsWall(physics, pose));
}

TEST_CASE("The space does not depend on the number of threads", "[placement]") {
  const Physics physics = test::physicsOf({test::redCellShape()}, test::twoChambers());
  const AccessibleSpace one(physics, 0, {}), three(physics, 0, Threads(3));
  REQUIRE(one.parts().size() == three.parts().size());
  for (std::size_t i = 0; i < one.parts().size(); ++i) {
    REQUIRE(one.parts()[i].centre == three.parts()[i].centre);
    REQUIRE(one.parts()[i].half == three.parts()[i].half);
    REQUIRE(one.parts()[i].orientation == three.parts()[i].orientation);
  }
}
