// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/block_owners.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <random>
#include <set>

using namespace packmesh;

namespace {

BlockGrid gridOf(int x, int y, int z, const Vec3& periodic) {
  const Vec3 size(x, y, z);
  return {{Vec3::Zero(), size}, periodic.cwiseProduct(size), 0.5, 1.0};
}

}  // namespace

TEST_CASE("Equal work is distributed equally, and empty blocks cost nothing", "[distributed]") {
  std::mt19937 random(1);
  for (const int ranks : {1, 2, 3, 7, 16}) {
    const BlockGrid grid = gridOf(12, 10, 8, Vec3::Ones());
    std::vector<std::int64_t> work(grid.count());
    for (std::int64_t& w : work) w = random() % 3 == 0 ? 90 + random() % 20 : 0;  // a vessel in its box
    const BlockOwners owners(grid, work, ranks);
    std::vector<std::int64_t> ofRank(ranks, 0);
    for (int b = 0; b < grid.count(); ++b) {
      REQUIRE(owners.of(b) >= 0);
      REQUIRE(owners.of(b) < ranks);
      ofRank[owners.of(b)] += work[b];
    }
    const double even = double(std::accumulate(work.begin(), work.end(), std::int64_t(0))) / ranks;
    CAPTURE(ranks, even, ofRank);
    REQUIRE(*std::max_element(ofRank.begin(), ofRank.end()) < even + 110);
    REQUIRE(*std::min_element(ofRank.begin(), ofRank.end()) > even - 110);
  }
}

TEST_CASE("Some ranks are idle if there are more ranks than blocks", "[distributed]") {
  const BlockGrid grid = gridOf(2, 1, 1, Vec3::Zero());
  const BlockOwners owners(grid, {5, 7}, 8);
  REQUIRE(owners.of(0) != owners.of(1));
  const BlockOwners none(grid, {0, 0}, 8);
  REQUIRE(none.of(0) == none.of(1));
}
