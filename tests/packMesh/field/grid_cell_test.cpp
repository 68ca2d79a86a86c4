// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/field/grid_cell.h"

#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <vector>

using namespace packmesh;

TEST_CASE("Points belong to the cell above their node, those on the last faces to the last cell", "[field]") {
  const std::array<int, 3> cells = {4, 1, 7};
  const GridCell inside(Vec3(2.25, 0.5, 6.0), cells);
  CHECK(inside.node[0] == 2);
  CHECK(inside.node[1] == 0);
  CHECK(inside.node[2] == 6);
  CHECK(inside.t[0] == 0.25);
  CHECK(inside.t[1] == 0.5);
  CHECK(inside.t[2] == 0.0);
  CHECK_FALSE(inside.isBeyond);
  const GridCell last(Vec3(4.0, 1.0, 7.0), cells);
  for (int k = 0; k < 3; ++k) {
    CHECK(last.node[k] == cells[k] - 1);
    CHECK(last.t[k] == 1.0);
  }
  CHECK_FALSE(last.isBeyond);
  CHECK(last.beyond == Vec3::Zero());
}

TEST_CASE("Points outside a grid belong to the cell of the nearest point of it", "[field]") {
  const std::array<int, 3> cells = {4, 3, 7};
  const GridCell cell(Vec3(-1.5, 1.5, 9.0), cells);
  CHECK(cell.isBeyond);
  CHECK(cell.beyond == Vec3(-1.5, 0.0, 2.0));
  CHECK(cell.node[0] == 0);
  CHECK(cell.t[0] == 0.0);
  CHECK(cell.node[1] == 1);
  CHECK(cell.t[1] == 0.5);
  CHECK(cell.node[2] == 6);
  CHECK(cell.t[2] == 1.0);
  const GridCell nowhere(Vec3::Constant(std::numeric_limits<double>::quiet_NaN()), cells);
  for (const int node : nowhere.node) CHECK(node == 0);
}

TEST_CASE("Interpolation looks up the corners of the cell, and is continuous from cell to cell", "[field]") {
  const std::array<int, 3> cells = {3, 4, 2};
  const std::size_t row = 4, slab = 20;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<double> values(60);
  for (double& v : values) v = unit(random);
  const auto valueAt = [&](const Vec3& u) {
    const GridCell cell(u, cells);
    const double* low = &values[cell.node[0] + row * cell.node[1] + slab * cell.node[2]];
    return cell.interpolate(row, slab, [&](std::size_t n) { return low[n]; }).value;
  };
  for (int k = 0; k <= 2; ++k)
    for (int j = 0; j <= 4; ++j)
      for (int i = 0; i <= 3; ++i)
        REQUIRE(valueAt(Vec3(i, j, k)) == Approx(values[i + row * j + slab * k]).margin(1e-14));
  constexpr double step = 1e-9;
  for (int n = 0; n < 300; ++n) {
    Vec3 u(3.0 * unit(random), 4.0 * unit(random), 2.0 * unit(random));
    const int axis = n % 3;
    u[axis] = std::round(u[axis]);
    REQUIRE(valueAt(u - step * Vec3::Unit(axis)) ==
            Approx(valueAt(u + step * Vec3::Unit(axis))).margin(5e-9));
  }
}
