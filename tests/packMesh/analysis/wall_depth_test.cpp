// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/analysis/wall_depth.h"

#include <catch2/catch.hpp>
#include <random>

#include "packMesh/container/primitives.h"
#include "packMesh/container/vessel.h"

using namespace packmesh;

TEST_CASE("Depths in a vessel are exact near its wall and accurate inside") {
  const auto tube = makeCylinder(Vec3::Zero(), 0, 10.0, 50.0, false);
  const auto vessel = makeVessel(tube->surface(), {}, 0.5);
  const WallDepth depth(*vessel->wall(), vessel->bounds());
  REQUIRE(depth.spacing() < 1.0);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  int exact = 0, interpolated = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 at(part(random), part(random), part(random));
    const Vec3 p = vessel->bounds().lo + at.cwiseProduct(vessel->bounds().size());
    const double truth = vessel->wall()->distance(p).distance, found = depth(p);
    INFO(p.transpose() << ": " << truth << ", " << found);
    REQUIRE(std::abs(found - truth) < 0.35 * depth.spacing());
    if (std::abs(truth) < 2.6 * depth.spacing()) REQUIRE(found == truth);
    ++(found == truth ? exact : interpolated);
  }
  REQUIRE(exact > 500);
  REQUIRE(interpolated > 500);
  const WallDepth closed(*tube->wall(), tube->bounds());
  REQUIRE(closed(Vec3(1, 2, 3)) == tube->wall()->distance(Vec3(1, 2, 3)).distance);
}
