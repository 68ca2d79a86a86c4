// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/placement/lumen_cut.h"

#include "packMesh/container/obstacles.h"
#include "packMesh/container/primitives.h"
#include "packMesh/container/region.h"
#include "packMesh/core/error.h"
#include "packMesh/placement/placement.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

/// A box 40 x 20 x 10 without these boxes.
std::shared_ptr<const Container> boxWithout(const std::vector<Box>& boxes, bool periodicAlongX = false) {
  std::vector<Obstacle> obstacles;
  for (const Box& box : boxes)
    obstacles.push_back({makeBox(box, {false, false, false})->surface(), "a wall"});
  return subtractObstacles(makeBox({Vec3::Zero(), Vec3(40, 20, 10)}, {periodicAlongX, false, false}),
                           std::move(obstacles));
}

/// Two branches from x = 15 on, y < 9 and y > 11.
const Box carina = {Vec3(15, 9, -1), Vec3(41, 11, 11)};

/// Calls check(point, depth) for points of a lumen with their depths below its wall.
template <class Check>
void forPoints(const Container& lumen, const Check& check) {
  const Box bounds = lumen.bounds();
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p = bounds.lo + bounds.size().cwiseProduct(evenPoint({0.1, 0.2, 0.3, 0.4}, i));
    if (const double depth = lumen.wall()->distance(p).distance; depth > 0.0) check(p, depth);
  }
}

}  // namespace

TEST_CASE("Beyond a cut is what is connected with its far side", "[cut]") {
  const auto lumen = boxWithout({carina});
  // Across the upper branch, straight and oblique.
  for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(3, 1, -1)}) {
    const Vec3 point(22, 15, 5), normal = direction.normalized();
    const LumenCut region(*lumen, point, direction, {});
    int beyond = 0;
    forPoints(*lumen, [&](const Vec3& p, double) {
      const bool inBranch = p.y() > 10.0, expected = inBranch && (p - point).dot(normal) >= 0.0;
      CAPTURE(p);
      CHECK(region.contains(p) == expected);
      beyond += expected;
      const WallDistance d = region.distance(p);
      CHECK(std::abs(d.distance) >= std::abs((p - point).dot(normal)) - 1e-9);
      CHECK(std::abs(d.distance) <= (p - point).norm() + 1e-9);
      if (direction.y() != 0.0 || !inBranch || p.x() < 15.0) return;
      CHECK(d.distance == Approx((p - point).dot(normal)).margin(1e-9));
      CHECK((d.gradient - normal).norm() < 1e-9);
    });
    CHECK(beyond > 500);
    CHECK(region.bounds().lo.y() > 10.0);
    CHECK(region.bounds().hi == Vec3(40, 20, 10));
  }
  const LumenCut back(*lumen, Vec3(22, 15, 5), Vec3(-2, 0, 0), {});
  CHECK(back.contains(Vec3(21, 15, 5)));
  CHECK(back.contains(Vec3(39, 4, 5)));
  CHECK_FALSE(back.contains(Vec3(23, 15, 5)));
}

TEST_CASE("A cut in the trunk has all branches beyond it", "[cut]") {
  const auto lumen = boxWithout({carina});
  const LumenCut region(*lumen, Vec3(10, 1, 1), Vec3(1, 0, 0), {});
  forPoints(*lumen, [&](const Vec3& p, double) { CHECK(region.contains(p) == (p.x() >= 10.0)); });
  CHECK(volumeInLumen(region, *lumen) == Approx(30.0 * 200.0 - 25.0 * 20.0).epsilon(0.01));
}

TEST_CASE("Only the section around the point is cut", "[cut]") {
  // One channel that runs forth, back and forth again.
  const auto lumen = boxWithout({{Vec3(-1, 6, -1), Vec3(34, 7, 11)}, {Vec3(6, 13, -1), Vec3(41, 14, 11)}});
  const LumenCut region(*lumen, Vec3(20, 10, 5), Vec3(-1, 0, 0), {});
  for (const double x : {3.0, 19.0, 21.0, 37.0}) {
    CAPTURE(x);
    CHECK_FALSE(region.contains(Vec3(x, 3, 5)));
    CHECK(region.contains(Vec3(x, 10, 5)) == (x < 20.0));
    CHECK(region.contains(Vec3(x, 17, 5)));
  }
  forPoints(*lumen, [&](const Vec3& p, double depth) {
    if (depth < 0.5) return;
    CHECK(region.contains(p) == (p.y() > 13.5 || (p.y() > 6.5 && p.x() <= 20.0)));
    CHECK(std::abs(region.distance(p).distance) <= (p - Vec3(20, 10, 5)).norm() + 1e-9);
  });
}

TEST_CASE("A cut that leaves the lumen connected is refused", "[cut]") {
  const auto around = boxWithout({{Vec3(15, 9, -1), Vec3(25, 11, 11)}});
  CHECK_THROWS_WITH(LumenCut(*around, Vec3(20, 15, 5), Vec3(1, 0, 0), {}),
                    Contains("(20, 15, 5) does not separate the lumen"));
  CHECK_THROWS_WITH(LumenCut(*around, Vec3(20, 10, 5), Vec3(1, 0, 0), {}),
                    Contains("(20, 10, 5) is not in the lumen"));
  CHECK_THROWS_AS(LumenCut(*around, Vec3(20, 99, 5), Vec3(1, 0, 0), {}), InputError);
  const auto endless = makeBox({Vec3::Zero(), Vec3(40, 20, 10)}, {true, true, true});
  CHECK_THROWS_WITH(LumenCut(*endless, Vec3(20, 10, 5), Vec3(1, 0, 0), {}), Contains("without walls"));
  CHECK(LumenCut(*around, Vec3(30, 15, 5), Vec3(1, 1, 0), {}).contains(Vec3(35, 15, 5)));
}

TEST_CASE("The ends of periods bound what is beyond a cut", "[cut]") {
  const auto lumen = boxWithout({carina}, true);
  const LumenCut region(*lumen, Vec3(22, 15, 5), Vec3(1, 0, 0), {});
  for (const double image : {-40.0, 0.0, 40.0}) {
    CHECK(region.distance(Vec3(38 + image, 15, 5)).distance == Approx(2.0));
    CHECK(region.distance(Vec3(24 + image, 15, 5)).distance == Approx(2.0));
    const WallDistance outside = region.distance(Vec3(1 + image, 15, 5));
    CHECK(outside.distance == Approx(-1.0));
    CHECK(outside.gradient == Vec3(-1, 0, 0));
  }
}

TEST_CASE("The side of a cut is the same for any number of threads", "[cut][threads]") {
  const auto lumen = boxWithout({carina});
  const LumenCut one(*lumen, Vec3(22, 15, 5), Vec3(3, 1, -1), {}),
      two(*lumen, Vec3(22, 15, 5), Vec3(3, 1, -1), Threads(3));
  forPoints(*lumen,
            [&](const Vec3& p, double) { CHECK(one.distance(p).distance == two.distance(p).distance); });
}
