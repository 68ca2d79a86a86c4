// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/analysis/cell_measures.h"

#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/packing/packing_problem.h"
#include "tests/support/catch.h"
#include "tests/support/packings.h"

using namespace packmesh;

namespace {

CellMeasures measured(const PackingProblem& problem, const std::vector<PlacedCell>& cells) {
  return measureCells(problem.physics, problem.execution, certificateInputOf(problem.physics, cells));
}

PlacedCell at(int species, const Vec3& position, double scale = 1.0) {
  PlacedCell cell;
  cell.species = cell.shape = species;
  cell.placement.linear *= scale;
  cell.placement.translation = position;
  return cell;
}

}  // namespace

TEST_CASE("The gap of a cell is that to the nearest other cell, across periodic faces, too") {
  PackingProblem problem;
  problem.physics.container = test::periodicCube(20.0);
  problem.physics.add("ball", test::sphereShape(1.0), 4);
  problem.physics.add("RBC", test::redCellShape(), 1);
  const std::vector<PlacedCell> cells = {at(0, {1.0, 2.0, 2.0}), at(0, {18.7, 2.0, 2.0}),
                                         at(0, {1.0, 4.2, 2.0}), at(0, {10.0, 16.0, 10.0}),
                                         at(1, {10.0, 10.0, 10.0})};
  const CellMeasures found = measured(problem, cells);
  const double spacing = test::sphereShape(1.0)->sampleSpacing();
  REQUIRE(spacing < 0.5);
  const auto within = [&](double gap, double exact) {
    REQUIRE(gap >= exact);                            // the mesh has its vertices on the sphere
    REQUIRE(gap <= exact + 0.5 * spacing * spacing);  // what a chord of that length misses of the sphere
  };
  REQUIRE(found.gap.size() == cells.size());
  within(found.gap[0], 0.2);
  within(found.gap[1], 0.3);
  within(found.gap[2], 0.2);
  REQUIRE(found.gap[3] == usualGapOfInterest);
  REQUIRE(found.gap[4] == usualGapOfInterest);
}

TEST_CASE("Gaps equal those between the meshes to the bit, from either side of a pair") {
  PackingProblem problem;
  problem.physics.container = test::periodicCube(14.0);
  problem.physics.add("RBC", test::redCellShape(), 5);
  problem.physics.add("PLT", test::hemocellShape("PLT"), 12);
  problem.physics.seed = 3;
  const PackingResult packed = pack(problem);
  REQUIRE(packed.outcome == Outcome::certified);
  const std::vector<PlacedCell>& cells = packed.cells;
  const std::vector<double> gaps = measured(problem, cells).gap;
  // Every pair of every image by itself.
  const auto mesh = [&](std::size_t i) -> const MeshHierarchy& {
    return problem.physics.shapeOf(cells[i]).hierarchy();
  };
  std::vector<double> expected(cells.size(), usualGapOfInterest);
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (std::size_t j = i + 1; j < cells.size(); ++j)
      for (int image = 0; image < 27; ++image) {
        Placement moved = cells[j].placement;
        moved.translation += 14.0 * Vec3(image % 3 - 1, image / 3 % 3 - 1, image / 9 - 1);
        const double gap = surfaceGap(mesh(i), cells[i].placement, mesh(j), moved, usualGapOfInterest);
        expected[i] = std::min(expected[i], gap);
        expected[j] = std::min(expected[j], gap);
      }
  REQUIRE(gaps == expected);
  REQUIRE(*std::min_element(gaps.begin(), gaps.end()) == packed.certificate.minimumGap);
}

TEST_CASE("The gap of overlapping cells is 0, that of scaled cells refers to their actual size") {
  PackingProblem problem;
  problem.physics.container = test::periodicCube(30.0);
  problem.physics.add("ball", test::sphereShape(1.0), 4);
  const CellMeasures found = measured(problem, {at(0, {5.0, 5.0, 5.0}), at(0, {6.5, 5.0, 5.0}),
                                                at(0, {20.0, 5.0, 5.0}, 2.0), at(0, {23.5, 5.0, 5.0})});
  REQUIRE(found.gap[0] == 0.0);
  REQUIRE(found.gap[1] == 0.0);
  REQUIRE(found.gap[2] == Approx(0.5).margin(0.03));
}

TEST_CASE("The local hematocrit counts only red cells, per volume of lumen") {
  PackingProblem problem;
  problem.physics.container = test::periodicCube(12.0);  // one box
  problem.physics.add("RBC", test::redCellShape(), 2);
  problem.physics.add("PLT", test::sphereShape(1.0), 1).inHematocrit = false;
  const std::vector<PlacedCell> cells = {at(0, {6.0, 3.0, 6.0}), at(0, {0.0, 8.0, 0.0}),
                                         at(1, {6.0, 6.0, 6.0})};
  const double hematocrit = 2.0 * test::redCellShape()->volume() / (12.0 * 12.0 * 12.0);
  for (const double local : measured(problem, cells).localHematocrit)
    REQUIRE(local == Approx(hematocrit).epsilon(1e-5));
}

TEST_CASE("The local hematocrit distinguishes dense and empty regions and excludes what is not lumen") {
  PackingProblem problem;
  problem.physics.container = makeCylinder({0.0, 0.0, 30.0}, 2, 8.0, 60.0, true);
  problem.physics.add("RBC", test::redCellShape(), 9);
  std::vector<PlacedCell> cells;
  for (int i = 0; i < 8; ++i) cells.push_back(at(0, {0.0, 0.0, 2.0 + 2.5 * (i % 8)}));
  cells.push_back(at(0, {0.0, 0.0, 45.0}));
  const std::vector<double> local = measured(problem, cells).localHematocrit;
  REQUIRE(local[3] > 3.0 * local[8]);
  // A single cell, in one or two slices of 10 µm of the tube.
  const double slice = problem.physics.container->volume() / 6.0;
  REQUIRE(local[8] < 1.3 * test::redCellShape()->volume() / slice);
  REQUIRE(local[8] > 0.3 * test::redCellShape()->volume() / slice);
}
