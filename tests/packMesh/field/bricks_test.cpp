// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/field/bricks.h"

#include <catch2/catch.hpp>
#include <cstdint>

using namespace packmesh;

namespace {

/// Fills a brick with what tells its values apart.
auto filledWith(int brick, int& fills) {
  return [brick, &fills](int* values) {
    ++fills;
    for (int n = 0; n < BrickView::nodes; ++n) values[n] = BrickView::nodes * brick + n;
    return true;
  };
}

}  // namespace

TEST_CASE("Bricks are filled once, when they are first needed", "[field]") {
  Bricks<int, std::int32_t> bricks({3, 2, 4});
  for (int b = 0; b < 24; ++b) REQUIRE(bricks.begins()[b] < 0);
  int fills = 0;
  for (const int brick : {23, 5, 0, 5, 23, 11}) {
    const int* values = bricks.at(brick, filledWith(brick, fills));
    REQUIRE(values == *bricks.values() + bricks.begins()[brick]);
    for (int n = 0; n < BrickView::nodes; ++n) REQUIRE(values[n] == BrickView::nodes * brick + n);
  }
  REQUIRE(fills == 4);
  REQUIRE(bricks.storedBricks() == 4);
  REQUIRE(bricks.begins()[1] < 0);
}

TEST_CASE("Bricks with nothing to tell are not stored, nor asked for again", "[field]") {
  Bricks<std::int8_t, std::int64_t> bricks({2, 2, 2});
  int asked = 0;
  const auto nothing = [&](std::int8_t*) {
    ++asked;
    return false;
  };
  for (int look = 0; look < 3; ++look) REQUIRE(bricks.at(3, nothing) == nullptr);
  REQUIRE(asked == 1);
  REQUIRE(bricks.storedBricks() == 0);
}

TEST_CASE("A brick has the nodes on its faces, and every cell lies in one brick", "[field]") {
  const int count[3] = {3, 2, 2};
  constexpr int cells = BrickView::cells;
  for (int z = 0; z < cells * count[2]; ++z)
    for (int y = 0; y < cells * count[1]; ++y)
      for (int x = 0; x < cells * count[0]; ++x) {
        const int node[3] = {x, y, z};
        REQUIRE(BrickView::brickOf(node, count) ==
                x / cells + count[0] * (y / cells + count[1] * (z / cells)));
        const int place = BrickView::placeOf(node);
        REQUIRE(place == x % cells + BrickView::row * (y % cells) + BrickView::slab * (z % cells));
        REQUIRE(place + 1 + BrickView::row + BrickView::slab < BrickView::nodes);  // the cell's far corner
      }
}
