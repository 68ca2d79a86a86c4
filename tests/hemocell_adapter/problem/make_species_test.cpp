// SPDX-License-Identifier: AGPL-3.0-or-later
// Species of plans, and shapes of the cells that have meshes of their own.
#include "hemocell_adapter/problem/make_species.h"

#include "hemocell_adapter/problem/counts.h"
#include "packMesh/core/error.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

namespace {

/// A box with red cells and platelets.
Problem boxed() {
  return test::planned({"30", "30", "30", "--rbc", "4", "--plt", "2"});
}

std::vector<Vec3> scaled(const TriangleMesh& mesh, double factor) {
  std::vector<Vec3> vertices = mesh.vertices;
  for (Vec3& v : vertices) v *= factor;
  return vertices;
}

/// Some cells of a file, of which the species and vertices are these; none: the template.
CellsOfFile cellsOf(const Problem& problem, const std::vector<int>& species,
                    const std::vector<std::vector<Vec3>>& vertices) {
  CellsOfFile all{"cells.h5", {}, {}, {}};
  for (std::size_t i = 0; i < species.size(); ++i) {
    PresentCell& cell = all.cells.emplace_back(PosLine{Vec3(3.0 * double(i), 0, 0), Vec3::Zero()});
    cell.vertices = vertices[i];
  }
  all.species = [species](std::size_t i) { return species[i]; };
  all.triangles = [&problem, species](std::size_t i) -> const std::vector<Triangle>& {
    return problem.species[species[i]].shape->mesh().triangles;
  };
  return all;
}

ShapedCells shapesOf(const Problem& problem, CellsOfFile cells,
                     SelfIntersecting what = SelfIntersecting::undeform, Notices* told = nullptr) {
  Notices notices;
  ShapedCells made =
      makeShapes(std::move(cells), problem.species, problem.shapes.size(), what, Threads(), notices);
  if (told) *told = notices;
  return made;
}

}  // namespace

TEST_CASE("Cells with meshes of their own get shapes, numbered in their order after the templates",
          "[make]") {
  const Problem problem = boxed();
  const TriangleMesh &red = problem.shapes[0]->mesh(), &platelet = problem.shapes[1]->mesh();
  const ShapedCells made =
      shapesOf(problem, cellsOf(problem, {1, 0, 0, 1}, {scaled(platelet, 1.1), {}, scaled(red, 0.9), {}}));
  REQUIRE(made.shapes.size() == 2);
  CHECK(made.cells[0].shape == 2);
  CHECK(made.cells[1].shape == -1);
  CHECK(made.cells[2].shape == 3);
  CHECK(made.cells[3].shape == -1);
  for (const PresentCell& cell : made.cells) CHECK(cell.vertices.empty());
  CHECK(made.shapes[0]->volume() == Approx(1.1 * 1.1 * 1.1 * problem.shapes[1]->volume()));
  CHECK(made.shapes[1]->volume() == Approx(0.9 * 0.9 * 0.9 * problem.shapes[0]->volume()));
}

TEST_CASE("Meshes that are not deformed templates are refused", "[make]") {
  const Problem problem = boxed();
  const TriangleMesh& red = problem.shapes[0]->mesh();
  CellsOfFile others = cellsOf(problem, {0}, {scaled(red, 1.0)});
  others.triangles = [&](std::size_t) -> const std::vector<Triangle>& {
    return problem.shapes[1]->mesh().triangles;
  };
  CHECK_THROWS_WITH(shapesOf(problem, std::move(others)), Contains("not those of the template"));
  CHECK_THROWS_WITH(shapesOf(problem, cellsOf(problem, {0}, {scaled(red, -1.0)})), Contains("inside out"));
  CHECK_THROWS_WITH(shapesOf(problem, cellsOf(problem, {0}, {scaled(red, 0.1)})), Contains("flat"));
}

TEST_CASE("Cells that intersect themselves are kept, undeformed or refused, as is asked for", "[make]") {
  const Problem problem = boxed();
  const TriangleMesh& red = problem.shapes[0]->mesh();
  std::vector<Vec3> crossing = red.vertices;
  crossing.front() += 0.9 * (Vec3(0, -4, 0) - 2.0 * crossing.front());  // through the other side
  const auto cells = [&] { return cellsOf(problem, {0, 0}, {scaled(red, 0.95), crossing}); };
  Notices told;
  CHECK(shapesOf(problem, cells(), SelfIntersecting::keep, &told).cells[1].shape == 3);
  CHECK(told.warnings.empty());
  const ShapedCells undeformed = shapesOf(problem, cells(), SelfIntersecting::undeform, &told);
  CHECK(undeformed.cells[0].shape == 2);
  CHECK(undeformed.cells[1].shape == -1);
  REQUIRE(told.warnings.size() == 1);
  CHECK_THAT(told.warnings[0],
             Contains("1 of its 2 cells 'RBC'") && Contains("it gets the undeformed shape"));
  CHECK_THROWS_WITH(shapesOf(problem, cells(), SelfIntersecting::refuse), Contains("the first is cell 2"));
}

TEST_CASE("Mean volumes are those of the cells there are, and count unless a volume is stated", "[make]") {
  Problem problem = boxed();
  const double red = problem.shapes[0]->volume();
  CHECK_FALSE(averagePresent(problem)[0]);
  const ShapedCells made =
      shapesOf(problem, cellsOf(problem, {0, 0}, {scaled(problem.shapes[0]->mesh(), 1.1), {}}));
  problem.shapes.insert(problem.shapes.end(), made.shapes.begin(), made.shapes.end());
  problem.species[0].start = made.cells;
  const MeanVolumes means = averagePresent(problem);
  REQUIRE(means[0]);
  CHECK(*means[0] == Approx(0.5 * (1.0 + 1.331) * red));
  CHECK_FALSE(means[1]);
  const auto counted = withMeanVolumes(problem.species, means, {});
  CHECK(counted[0].meanVolume == *means[0]);
  CHECK(counted[0].countedVolume == *means[0]);
  CHECK(counted[1].meanVolume == problem.species[1].meanVolume);
  const auto stated = withMeanVolumes(problem.species, means, 97.0);
  CHECK(stated[0].meanVolume == *means[0]);
  CHECK(stated[0].countedVolume == problem.species[0].countedVolume);
  CHECK(withCounts(problem.species, {7, 0})[0].count == 7);
}
