// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/placement/placement.h"

#include <catch2/catch.hpp>

#include "packMesh/container/primitives.h"
#include "tests/support/physics.h"
#include "tests/support/shapes.h"

using namespace packmesh;

namespace {

bool same(const Pose& a, const Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs() && a.scale == b.scale;
}

Physics redCellsIn(const Box& bounds, std::uint64_t seed = 1) {
  Physics physics = test::physicsOf({test::redCellShape()}, makeBox(bounds, {true, true, true}));
  physics.seed = seed;
  return physics;
}

}  // namespace

TEST_CASE("Initial positions are uniform over a periodic box", "[placement]") {
  const Box bounds{{-5, 0, 10}, {15, 30, 20}};
  constexpr int count = 20000;
  const std::vector<Pose> poses = placeRandomly(redCellsIn(bounds), {}, 0, 0, 0, count);
  REQUIRE(poses.size() == count);
  Vec3 mean = Vec3::Zero(), squares = Vec3::Zero(), axis = Vec3::Zero();
  for (const Pose& pose : poses) {
    REQUIRE(bounds.contains(pose.position));
    REQUIRE(pose.scale == 1.0);
    REQUIRE(pose.orientation.norm() == Approx(1.0));
    const Vec3 u = (pose.position - bounds.lo).cwiseQuotient(bounds.size());
    mean += u;
    squares += (u.array() - 0.5).square().matrix();
    axis += pose.orientation * Vec3::UnitY();
  }
  REQUIRE((mean / count - Vec3::Constant(0.5)).norm() < 0.02);
  REQUIRE((squares / count - Vec3::Constant(1.0 / 12.0)).norm() < 0.01);
  REQUIRE((axis / count).norm() < 0.05);
}

TEST_CASE("Initial positions are more evenly spread than independent points", "[placement]") {
  const Box bounds{{0, 0, 0}, {50, 50, 50}};
  constexpr int perEdge = 5, count = 1000;
  for (const std::uint64_t seed : {1, 2, 3}) {
    std::vector<int> cells(perEdge * perEdge * perEdge, 0);
    for (const Pose& pose : placeRandomly(redCellsIn(bounds, seed), {}, 0, 0, 0, count)) {
      const Vec3 at = perEdge * pose.position.cwiseQuotient(bounds.size());
      ++cells[int(at.x()) + perEdge * (int(at.y()) + perEdge * int(at.z()))];
    }
    const double mean = double(count) / double(cells.size());
    double variance = 0.0;
    for (const int n : cells) variance += (n - mean) * (n - mean) / double(cells.size());
    CHECK(variance < 0.5 * mean);  // of independent points: the mean
  }
}

TEST_CASE("A pose is a function of the seed and the cell's number alone", "[placement]") {
  const Box bounds{{0, 0, 0}, {20, 20, 20}};
  const std::vector<Pose> all = placeRandomly(redCellsIn(bounds, 3), {}, 0, 0, 0, 50);
  const std::vector<Pose> some = placeRandomly(redCellsIn(bounds, 3), {}, 0, 0, 20, 10);
  for (int i = 0; i < 10; ++i) REQUIRE(same(some[i], all[20 + i]));
  const std::vector<Pose> other = placeRandomly(redCellsIn(bounds, 4), {}, 0, 0, 0, 50);
  for (int i = 0; i < 50; ++i) REQUIRE_FALSE(same(other[i], all[i]));
  Physics unrotated = redCellsIn(bounds, 3);
  unrotated.rotate = false;
  const std::vector<Pose> still = placeRandomly(unrotated, {}, 0, 0, 0, 50);
  for (int i = 0; i < 50; ++i) {
    REQUIRE(still[i].position == all[i].position);
    REQUIRE(still[i].orientation.coeffs() == Quaternion::Identity().coeffs());
  }
  REQUIRE(placeRandomly(redCellsIn(bounds, 3), {}, 0, 0, 0, 0).empty());
}

TEST_CASE("Initial positions are inside the lumen, and away from the wall where there is room",
          "[placement]") {
  const auto shape = test::redCellShape();
  const std::shared_ptr<const Container> sphere = makeSphere(Vec3(1, 2, 3), 10.0);
  const double thin = shape->bound().semiAxes.minCoeff();
  for (const Pose& pose : placeRandomly(test::physicsOf({shape}, sphere), {}, 0, 0, 0, 500))
    REQUIRE(sphere->wall()->distance(pose.position).distance >= thin);
  // No room: as far inside as the tries came.
  const std::shared_ptr<const Container> narrow = makeCylinder(Vec3::Zero(), 0, 0.5, 40.0, true);
  for (const Pose& pose : placeRandomly(test::physicsOf({shape}, narrow), {}, 0, 0, 0, 50))
    REQUIRE(narrow->wall()->distance(pose.position).distance > 0.4);
}
