// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/overlap_finder.h"
#include "packMesh/certificate/certifier.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/parallel/blocks.h"
#include "tests/support/catch.h"
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

namespace {

/// A double pyramid with these semi-axes around a centre.
TriangleMesh pyramids(const Vec3& center, const Vec3& semi) {
  TriangleMesh mesh;
  for (int k = 0; k < 3; ++k)
    for (const double sign : {1.0, -1.0}) mesh.vertices.push_back(center + sign * semi[k] * Vec3::Unit(k));
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  return mesh;
}

/// The faults of meshes, each of a kind of its own, examined a few at a time.
MeshFaults faultsOf(const std::vector<TriangleMesh>& meshes, const Vec3& period = Vec3::Zero(),
                    const Threads& threads = {}, std::int64_t atATime = 1000) {
  MeshesOfKinds kinds;
  for (const TriangleMesh& mesh : meshes) kinds.kinds.push_back({mesh.triangles, 1});
  kinds.make = [&](std::size_t kind, std::int64_t, std::vector<Vec3>& vertices) {
    vertices = meshes[kind].vertices;
  };
  const MeshOverlaps overlaps(kinds, period, threads);
  MeshFaults all;
  for (std::int64_t begin = 0; begin < overlaps.count(); begin += atATime) {
    const MeshFaults some = overlaps.examine(begin, std::min(begin + atATime, overlaps.count()));
    all.overlapping.insert(all.overlapping.end(), some.overlapping.begin(), some.overlapping.end());
    all.selfIntersecting.insert(all.selfIntersecting.end(), some.selfIntersecting.begin(),
                                some.selfIntersecting.end());
  }
  sortByCells(all.overlapping);
  return all;
}

std::vector<OverlappingPair> findMeshOverlaps(const std::vector<TriangleMesh>& meshes,
                                              const Threads& threads = {}, std::int64_t atATime = 1000) {
  return faultsOf(meshes, Vec3::Zero(), threads, atATime).overlapping;
}

}  // namespace

TEST_CASE("Meshes meet periodic images of others, and of themselves", "[certificate]") {
  // The first is longer than the period along x, the second crosses a face along y, the third meets it there.
  const std::vector<TriangleMesh> meshes = {pyramids({5, 5, 5}, {6, 1, 1}), pyramids({5, 0, 1}, {1, 1, 0.5}),
                                            pyramids({5, 9.5, 1}, {1, 1, 0.5})};
  CHECK(faultsOf(meshes).overlapping.empty());
  const std::vector<OverlappingPair> found = faultsOf(meshes, {10, 10, 0}).overlapping;
  REQUIRE(found.size() == 2);
  CHECK((found[0].first == 0 && found[0].second == 0 && found[0].shift == Vec3(10, 0, 0)));
  CHECK((found[1].first == 1 && found[1].second == 2 && found[1].shift == Vec3(0, -10, 0)));
}

TEST_CASE("Meshes that intersect themselves are named", "[certificate]") {
  TriangleMesh twice = pyramids({0, 0, 0}, {4, 4, 4});
  twice.vertices[4] = Vec3(3, 0, -5);  // through the lower pyramid
  const MeshFaults found = faultsOf({pyramids({20, 0, 0}, {1, 1, 1}), twice});
  CHECK(found.overlapping.empty());
  REQUIRE(found.selfIntersecting.size() == 1);
  CHECK(found.selfIntersecting[0].cell == 1);
}

TEST_CASE("Meshes of different shapes are tested against each other", "[certificate]") {
  // The first meets the second in a single point, and contains the third.
  const std::vector<TriangleMesh> meshes = {pyramids({0, 0, 0}, {2, 2, 2}), pyramids({3, 0, 0}, {1, 5, 1}),
                                            pyramids({0.1, 0, 0}, {0.5, 0.25, 0.25}),
                                            pyramids({0, 10, 0}, {1, 1, 1})};
  const std::vector<OverlappingPair> found = findMeshOverlaps(meshes);
  REQUIRE(found.size() == 2);
  CHECK((found[0].first == 0 && found[0].second == 1 && !found[0].contained));
  CHECK((found[1].first == 0 && found[1].second == 2 && found[1].contained));
  CHECK(findMeshOverlaps({meshes[1], meshes[2], meshes[3]}).empty());
  CHECK(findMeshOverlaps({}).empty());
}

TEST_CASE("All overlapping meshes are found, on any number of threads", "[certificate]") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0.0, 12.0), size(0.3, 3.0);
  std::vector<TriangleMesh> meshes;
  for (int i = 0; i < 120; ++i)
    meshes.push_back(
        pyramids({place(random), place(random), place(random)}, {size(random), size(random), size(random)}));
  std::vector<std::pair<std::int64_t, std::int64_t>> expected, alone, shared;
  for (std::size_t i = 0; i < meshes.size(); ++i)
    for (std::size_t j = i + 1; j < meshes.size(); ++j)
      if (relate(MeshHierarchy(meshes[i]), Placement(), MeshHierarchy(meshes[j]), Placement()).relation !=
          MeshRelation::apart)
        expected.emplace_back(i, j);
  for (const OverlappingPair& pair : findMeshOverlaps(meshes)) alone.emplace_back(pair.first, pair.second);
  for (const OverlappingPair& pair : findMeshOverlaps(meshes, Threads(3), 7))
    shared.emplace_back(pair.first, pair.second);
  REQUIRE(expected.size() > 100);
  CHECK(alone == expected);
  CHECK(shared == expected);
}
