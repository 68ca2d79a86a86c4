// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/field/sampled_distance.h"
#include "packMesh/core/error.h"
#include "tests/support/catch.h"
#include "tests/support/walls.h"

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

using test::NamedContainer;

namespace {

std::vector<Vec3> pointsIn(const Box& box, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<Vec3> points;
  for (int n = 0; n < count; ++n)
    points.push_back(box.lo + box.size().cwiseProduct(Vec3(unit(random), unit(random), unit(random))));
  return points;
}

}  // namespace

TEST_CASE("A sampled wall interpolates the distance and its gradient", "[container]") {
  for (const NamedContainer& c : test::allContainers()) {
    CAPTURE(c.name);
    const Box region = c.container->bounds().grownBy(1.5);
    if (region.volume() > 1e5) continue;
    const SampledDistance sampled(c.wall(), region, 0.25);
    double worst = 0.0;
    int off = 0, checked = 0;
    for (const Vec3& p : pointsIn(region, 3000, 1)) {
      const WallDistance found = sampled.sample(p), expected = c.wall().distance(p);
      if (std::abs(expected.distance) > 1.0) {
        // At most too large by an interpolation. Deep outside of the lumen nobody is; of obstacles further
        // away only the bounding box is seen.
        if (expected.distance > 0.0 && expected.distance < 2.0)
          REQUIRE(found.distance <= expected.distance + 0.26 * 0.25 + c.wall().slack());
        continue;
      }
      ++checked;
      worst = std::max(worst, std::abs(found.distance - expected.distance));
      off += (found.gradient - expected.gradient).norm() > 0.15;
    }
    REQUIRE(checked > 50);
    REQUIRE(worst < 0.3 * 0.25);
    REQUIRE(off < 0.2 * checked);  // along edges
  }
}

TEST_CASE("A linear distance is reproduced to the steps of its storage, across bricks too", "[field]") {
  struct Plane : DistanceSource {
    Vec3 normal = Vec3(0.48, -0.6, 0.64);
    double distance(const Vec3& p) const { return normal.dot(p) - 0.3; }
    void sample(const NodeBlock& block, float* distances) const override {
      for (int k = 0; k < block.nodes[2]; ++k)
        for (int j = 0; j < block.nodes[1]; ++j)
          for (int i = 0; i < block.nodes[0]; ++i) *distances++ = float(distance(block.position(i, j, k)));
    }
  } const plane;
  constexpr double spacing = 0.25, brick = spacing * BrickView::cells;
  const double step = spacing / BrickView::stepsPerSpacing;
  const Box region{Vec3::Constant(-3.0), Vec3::Constant(3.0)};
  const SampledDistance sampled(plane, region, spacing);
  int n = 0;
  for (Vec3 p : pointsIn(region, 2000, 4)) {
    if (++n % 2 == 0) p[n % 3] = brick * std::round(p[n % 3] / brick);  // on a face between two bricks
    const DistanceSample found = sampled.sample(p);
    REQUIRE(std::abs(found.distance - plane.distance(p)) < 0.51 * step);
    REQUIRE(sampled.distance(p) == found.distance);
    REQUIRE((found.gradient - plane.normal).cwiseAbs().maxCoeff() < 1.01 * step / spacing);
  }
}

TEST_CASE("Gradients of a sampled wall are differences of its distances", "[container]") {
  const auto sphere = makeSphere(Vec3::Zero(), 5.0);
  const Box region = sphere->bounds().grownBy(1.0);
  const SampledDistance sampled(*sphere->wall(), region, 0.25);
  constexpr double step = 1e-6;
  int compared = 0;
  for (const Vec3& p : pointsIn(region, 1000, 5)) {
    const Vec3 inCell = p / 0.25 - Vec3((p / 0.25).array().floor());
    if (inCell.minCoeff() < 1e-3 || inCell.maxCoeff() > 1.0 - 1e-3) continue;  // differences within a cell
    ++compared;
    const Vec3 gradient = sampled.sample(p).gradient;
    for (int k = 0; k < 3; ++k) {
      const double ahead = sampled.sample(p + step * Vec3::Unit(k)).distance;
      const double behind = sampled.sample(p - step * Vec3::Unit(k)).distance;
      REQUIRE(gradient[k] == Approx((ahead - behind) / (2.0 * step)).margin(1e-7));
    }
  }
  REQUIRE(compared > 900);
}

TEST_CASE("The distance to a sampled wall decreases further beyond its region", "[container]") {
  const auto sphere = makeSphere(Vec3::Zero(), 5.0);
  const SampledDistance sampled(*sphere->wall(), sphere->bounds(), 0.25);
  // Bricks are whole: the region ends at 6 µm at the latest.
  const double edge = sampled.sample(Vec3(6.0, 0.0, 0.0)).distance;
  REQUIRE(edge == Approx(-1.0).margin(0.02));
  const WallDistance beyond = sampled.sample(Vec3(9.0, 0.0, 0.0));
  REQUIRE(beyond.distance == Approx(edge - 3.0));
  REQUIRE(beyond.gradient.x() == -1.0);
  REQUIRE(sampled.sample(Vec3(-9.0, 7.0, 0.0)).gradient.y() == -1.0);
}

TEST_CASE("A sampled wall rejects a region too large for its table", "[container]") {
  const auto sphere = makeSphere(Vec3::Zero(), 5.0);
  // 1.4 and 0.7 of the bricks there may be.
  const Box tooLarge{Vec3::Zero(), Vec3(1440.0, 1440.0, 1440.0)}, far{Vec3::Zero(), Vec3(3e6, 150.0, 3.0)};
  CHECK_THROWS_WITH(SampledDistance(*sphere->wall(), tooLarge, 0.25),
                    Contains("distances in 1.44e+03 x 1.44e+03 x 1.44e+03 µm cannot be sampled"));
  CHECK_THROWS_AS(SampledDistance(*sphere->wall(), Box{Vec3::Zero(), Vec3::Constant(1e9)}, 0.25), InputError);
  CHECK(SampledDistance(*sphere->wall(), far, 0.25).sample(Vec3(0.0, 0.0, 1.0)).distance ==
        Approx(4.0).margin(0.02));
}

TEST_CASE("The distances of a sampled wall do not depend on the order of queries", "[container]") {
  for (const NamedContainer& c : test::allContainers()) {
    CAPTURE(c.name);
    const Box region = c.container->bounds().grownBy(1.0);
    if (region.volume() > 1e5) continue;
    std::vector<Vec3> points = pointsIn(region, 500, 2);
    const SampledDistance one(c.wall(), region, 0.25), other(c.wall(), region, 0.25);
    std::vector<double> forwards, backwards;
    for (const Vec3& p : points) forwards.push_back(one.sample(p).distance);
    std::reverse(points.begin(), points.end());
    for (const Vec3& p : points) backwards.push_back(other.sample(p).distance);
    std::reverse(backwards.begin(), backwards.end());
    REQUIRE(forwards == backwards);
  }
}

TEST_CASE("Walls give the same distances for blocks of nodes as for single nodes", "[container]") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const NamedContainer& c : test::allContainers()) {
    CAPTURE(c.name);
    const Box box = c.container->bounds().grownBy(1.0);
    int compared = 0;
    for (int n = 0; n < 60; ++n) {
      NodeBlock block;
      block.spacing = n % 2 == 0 ? 0.25 : 1.0;
      block.origin = box.lo + box.size().cwiseProduct(Vec3(unit(random), unit(random), unit(random)));
      std::size_t count = 1;
      for (int& nodes : block.nodes) count *= nodes = 1 + int(random() % 9);
      std::vector<float> distances(count);
      c.wall().sample(block, distances.data());
      std::size_t index = 0;
      for (int k = 0; k < block.nodes[2]; ++k)
        for (int j = 0; j < block.nodes[1]; ++j)
          for (int i = 0; i < block.nodes[0]; ++i, ++index) {
            const double expected = c.wall().distance(block.position(i, j, k)).distance;
            CAPTURE(block.position(i, j, k), block.spacing, expected, distances[index]);
            REQUIRE(distances[index] <= expected + 1e-4 * (1.0 + std::abs(expected)));
            REQUIRE(distances[index] >= (expected > 0.0 ? 0.59 * expected : expected - 1e-4) - 1e-4);
            if (expected > 1.5 * block.spacing) continue;  // rough
            ++compared;
            REQUIRE(distances[index] == Approx(expected).margin(1e-4));
          }
    }
    REQUIRE(compared > 500);
  }
}
