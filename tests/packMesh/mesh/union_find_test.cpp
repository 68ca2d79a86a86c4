// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/union_find.h"
#include "tests/support/catch.h"

using namespace packmesh;

TEST_CASE("Joined sets are named by their smallest number", "[mesh]") {
  UnionFind sets(6);
  for (int i = 0; i < 6; ++i) CHECK(sets.first(i) == i);
  sets.join(4, 5);
  sets.join(2, 5);
  sets.join(2, 4);  // already in one set
  sets.join(3, 3);
  const int expected[] = {0, 1, 2, 3, 2, 2};
  for (int i = 0; i < 6; ++i) CHECK(sets.first(i) == expected[i]);
}

TEST_CASE("Joined sets are those of a search without them, in any order", "[mesh]") {
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    constexpr int count = 60;
    std::uniform_int_distribution<int> any(0, count - 1);
    UnionFind sets(count);
    std::vector<int> name(count);
    std::iota(name.begin(), name.end(), 0);
    for (int n = 0; n < 40; ++n) {
      const int i = any(random), j = any(random);
      sets.join(i, j);
      const int kept = std::min(name[i], name[j]), lost = std::max(name[i], name[j]);
      std::replace(name.begin(), name.end(), lost, kept);
      for (int k = 0; n % 7 == 0 && k < count; ++k) REQUIRE(sets.first(k) == name[k]);
    }
    for (int k = 0; k < count; ++k) REQUIRE(sets.first(k) == name[k]);
  }
}
