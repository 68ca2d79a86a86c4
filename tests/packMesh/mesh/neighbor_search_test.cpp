// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/neighbor_search.h"
#include "tests/support/catch.h"

using namespace packmesh;

TEST_CASE("SphereGrid finds the same pairs as brute force, for mixed sizes", "[geometry]") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> coordinate(-20.0, 20.0), exponent(-3.0, 3.0);
    std::vector<Sphere> spheres(200);
    for (Sphere& s : spheres)
      s = {{coordinate(random), coordinate(random), 0.2 * coordinate(random)}, std::exp2(exponent(random))};
    const SphereGrid grid(spheres);
    for (double margin : {0.0, 0.5}) {
      for (int i = 0; i < 200; ++i) {
        std::multiset<int> found, expected;
        grid.forEachNear(spheres[i], margin, [&](int j) { found.insert(j); });
        for (int j = 0; j < 200; ++j)
          if ((spheres[i].center - spheres[j].center).norm() < spheres[i].radius + spheres[j].radius + margin)
            expected.insert(j);
        REQUIRE(found == expected);
      }
    }
  }
}

TEST_CASE("SphereGrid handles no spheres, one sphere and coinciding spheres", "[geometry]") {
  int visits = 0;
  SphereGrid({}).forEachNear({Vec3::Zero(), 1.0}, 0.0, [&](int) { ++visits; });
  REQUIRE(visits == 0);
  SphereGrid({{Vec3::Zero(), 1.0}, {Vec3::Zero(), 1.0}, {Vec3::Zero(), 0.0}})
      .forEachNear({Vec3::Zero(), 1.0}, 0.0, [&](int) { ++visits; });
  REQUIRE(visits == 3);
}
