// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/field/sampled_distance.h"

#include <catch2/catch.hpp>
#include <random>

#include "packMesh/core/error.h"
#include "tests/support/walls.h"

using namespace packmesh;
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
          for (int i = 0; i < block.nodes[0]; ++i)
            *distances++ = static_cast<float>(distance(block.position(i, j, k)));
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
                    Catch::Contains("distances in 1.44e+03 x 1.44e+03 x 1.44e+03 µm cannot be sampled"));
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
      for (int& nodes : block.nodes) count *= nodes = 1 + static_cast<int>(random() % 9);
      std::vector<float> distances(count);
      c.wall().sample(block, distances.data());
      std::size_t index = 0;
      for (int k = 0; k < block.nodes[2]; ++k)
        for (int j = 0; j < block.nodes[1]; ++j)
          for (int i = 0; i < block.nodes[0]; ++i, ++index) {
            const double expected = c.wall().distance(block.position(i, j, k)).distance;
            CAPTURE(block.position(i, j, k).transpose(), block.spacing, expected, distances[index]);
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
