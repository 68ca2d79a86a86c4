// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/overlap_finder.h"

#include <catch2/catch.hpp>
#include <random>

#include "packMesh/certificate/certify.h"
#include "packMesh/container/primitives.h"
#include "packMesh/parallel/periodic_images.h"
#include "tests/packMesh/mesh/test_meshes.h"
#include "tests/support/physics.h"
#include "tests/support/shapes.h"

using namespace packmesh;

TEST_CASE(
    "Overlaps of cells that have moved, through periodic faces too, are found among their first neighbours",
    "[certificate]") {
  const Box bounds{Vec3::Zero(), Vec3(11.0, 9.0, 10.0)};
  const auto shape = test::sphereShape(1.0);
  const Physics physics = test::physicsOf({shape}, makeBox(bounds, {true, true, true}));
  const Vec3 period = physics.container->period();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  constexpr double farthest = 0.5;
  std::vector<PlacedCell> cells;
  std::vector<Sphere> spheres;
  std::vector<Vec3> positions;
  for (int i = 0; i < 60; ++i) {
    const Vec3 at = Vec3(uniform(random), uniform(random), uniform(random)).cwiseProduct(bounds.hi);
    cells.push_back({0, 0, {test::randomRotation(random), at}});
    spheres.push_back({at, shape->reach() + farthest});
    positions.push_back(at);
  }
  const PeriodicNeighbors neighbors(spheres, period);
  const CertificateInput input = certificateInputOf(physics, cells);
  const OverlapFinder overlaps(input, neighbors, positions);
  std::size_t found = 0;
  int wrappedCells = 0;
  for (int round = 0; round < 5; ++round) {
    std::vector<std::int64_t> moved;
    for (std::int64_t i = round % 2; i < 60; i += 2) {
      const Vec3 there = positions[i] + farthest * uniform(random) * test::randomDirection(random);
      cells[i].placement.translation = wrapped(there, bounds, period);
      wrappedCells += cells[i].placement.translation != there;
      moved.push_back(i);
    }
    const std::vector<OverlappingPair> expected = findOverlaps(input, moved), pairs = overlaps(moved);
    REQUIRE(pairs.size() == expected.size());
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      CHECK(pairs[k].first == expected[k].first);
      CHECK(pairs[k].second == expected[k].second);
      CHECK(pairs[k].shift == expected[k].shift);
    }
    found += pairs.size();
  }
  CHECK(found > 50);
  CHECK(wrappedCells > 5);
}
