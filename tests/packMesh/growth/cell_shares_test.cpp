// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/cell_shares.h"

#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "packMesh/core/box.h"

using namespace packmesh;

TEST_CASE("Bisection gives groups of equal size with nearby points") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const int points : {0, 1, 5, 64, 1000})
    for (const int parts : {1, 2, 3, 4, 7, 8}) {
      CAPTURE(points, parts);
      std::vector<Vec3> centres;
      for (int i = 0; i < points; ++i)
        centres.emplace_back(40.0 * unit(random), 10.0 * unit(random), unit(random));
      const std::vector<std::vector<int>> groups = bisected(centres, parts);
      REQUIRE(groups.size() == std::size_t(parts));
      std::set<int> seen;
      double volume = 0.0;
      for (const std::vector<int>& group : groups) {
        REQUIRE(std::is_sorted(group.begin(), group.end()));
        REQUIRE(std::abs(double(group.size()) - double(points) / parts) <= 3.0);
        Box box;
        for (const int i : group) box.add(centres[i]), seen.insert(i);
        volume += box.volume();
      }
      REQUIRE(seen.size() == std::size_t(points));
      REQUIRE(volume <= 400.0);  // no group reaches into another
      REQUIRE(bisected(centres, parts) == groups);
    }
}

TEST_CASE("A single rank works on all cells") {
  const CellShares shares;
  REQUIRE(shares.alone());
  REQUIRE(shares.own(17));
  REQUIRE(shares.ownOf({3, 5}) == std::vector<std::int64_t>{3, 5});
}
