// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/problem/physics.h"

#include "packMesh/packing/problem_digest.h"
#include "tests/support/catch.h"
#include "tests/support/deformed.h"
#include "tests/support/packings.h"

using namespace packmesh;

namespace {

Pose poseAt(const Vec3& position) {
  return {1.0, Quaternion::Identity(), position};
}

/// Six red cells, of which the first three are deformed: two alike, the third and the fourth at given poses;
/// and balls. Another form of the red cell is not in use.
PackingProblem someDeformed() {
  PackingProblem problem;
  problem.physics.container = test::periodicCube(30.0);
  Physics& physics = problem.physics;
  physics.add("ball", test::sphereShape(1.0), 2);
  Species& red = physics.add("RBC", test::redCellShape(), 6);
  for (const int seed : {1, 2, 3})
    physics.shapes.push_back(
        std::make_shared<const Shape>(test::deformed(physics.shapes[1]->mesh(), seed), physics.shapes[1]));
  red.deformed = {{2, {}}, {2, {}}, {4, poseAt({5.0, 5.0, 5.0})}};
  red.start = {poseAt({15.0, 15.0, 15.0})};
  return problem;
}

Physics cellsInTube() {
  Physics physics;
  physics.container = makeCylinder(Vec3(15, 0, 0), 0, 5.0, 30.0, true);
  const auto shape = test::redCellShape();
  physics.add("RBC", shape, 3);
  physics.add("stiff", shape, 1);
  return physics;
}

}  // namespace

TEST_CASE("The deformed cells of a species are its first ones, with their constraints", "[shapes]") {
  const PackingProblem problem = someDeformed();
  const Physics& physics = problem.physics;
  const Species& red = physics.species[1];
  CHECK(red.undeformed() == 3);
  CHECK(red.placed() == 2);
  CHECK(physics.hasDeformed());
  CHECK(physics.shapesInUse() == std::vector<int>{0, 1, 2, 4});
  const double volume = 2.0 * physics.shapes[2]->volume() + physics.shapes[4]->volume();
  CHECK(meanVolume(red, physics.shapes) == Approx((volume + 3.0 * physics.shapes[1]->volume()) / 6.0));
  std::vector<bool> given;
  for (int n = 0; n < 6; ++n) given.push_back(red.startsAtGivenPose(n));
  CHECK(given == std::vector<bool>{false, false, true, true, false, false});

  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::certified);
  std::vector<int> species, shapes;
  double all = 0.0;
  for (const PlacedCell& cell : result.cells) {
    species.push_back(cell.species);
    shapes.push_back(cell.shape);
    all += physics.shapeOf(cell).volume();
    CHECK(physics.isDeformed(cell) == (cell.shape > 1));
  }
  CHECK(species == std::vector<int>{0, 0, 1, 1, 1, 1, 1, 1});
  CHECK(shapes == std::vector<int>{0, 0, 2, 2, 4, 1, 1, 1});
  CHECK(result.certificate.cellVolume == Approx(all));
  CHECK(result.certificate.clean());
}

TEST_CASE("Fewer cells of a species are its first ones", "[shapes]") {
  Species red = someDeformed().physics.species[1];
  red.resize(4);
  CHECK(red.deformed.size() == 3);
  CHECK(red.placed() == 2);
  red.resize(2);
  CHECK(red.deformed.size() == 2);
  CHECK(red.start.empty());
  CHECK(red.placed() == 0);
  CHECK_FALSE(red.usesTemplate());
}

TEST_CASE("Shapes that no cell has do not change a packing", "[shapes]") {
  PackingProblem problem = someDeformed();
  const PackingResult result = pack(problem);
  std::vector<Vec3> wide = problem.physics.shapes[3]->mesh().vertices;
  for (Vec3& v : wide) v *= 1.5;
  problem.physics.shapes[3] = std::make_shared<const Shape>(std::move(wide), problem.physics.shapes[1]);
  CHECK(test::sameBits(pack(problem), result));
}

TEST_CASE("Shapes of cells are forms of the templates of their species", "[shapes]") {
  const PackingProblem good = someDeformed();
  CHECK(good.physics.areOfCell(1, 1));
  CHECK(good.physics.areOfCell(1, 3));
  for (const auto& [species, shape] : {std::pair(0, 1), {0, 3}, {1, 0}, {1, 5}, {1, -1}, {2, 0}, {-1, 0}})
    CHECK_FALSE(good.physics.areOfCell(species, shape));
  validate(good);
  for (const int shape : {-1, 0, 1, 5}) {
    PackingProblem problem = good;
    problem.physics.species[1].deformed[1].shape = shape;
    CHECK_THROWS_WITH(validate(problem),
                      "species 'RBC' has a deformed cell whose shape is not a form of its template");
  }
  PackingProblem problem = good;
  problem.physics.species[1].count = 2;
  CHECK_THROWS_WITH(validate(problem), "species 'RBC' has more deformed cells than cells");
  problem = good;
  problem.physics.species[1].freedom.fixed = true;
  CHECK_THROWS_WITH(validate(problem), "species 'RBC' is fixed, so each of its cells needs an initial pose");
}

TEST_CASE("Problems differ in the shapes of their cells", "[shapes]") {
  const PackingProblem problem = someDeformed();
  PackingProblem other = problem;
  other.physics.species[1].deformed[0].shape = 3;
  CHECK(digestOf(other) != digestOf(problem));
  other = problem;
  other.physics.shapes[4] = other.physics.shapes[3];
  CHECK(digestOf(other) != digestOf(problem));
  other = problem;
  other.physics.species[1].deformed[2].start.reset();
  CHECK(digestOf(other) != digestOf(problem));
  other = problem;
  other.physics.species[1].kind = "red";
  CHECK(digestOf(other) == digestOf(problem));
}

TEST_CASE("Cells of a finished packing get meshes of their own", "[shapes]") {
  const PackingProblem problem = someDeformed();
  const PackingResult result = pack(problem);
  Physics physics = problem.physics;
  std::vector<PlacedCell> cells = result.cells;
  const std::vector<Vec3> first = test::deformed(physics.shapes[1]->mesh(), 7),
                          second = test::deformed(physics.shapes[1]->mesh(), 8);
  deform(cells, {{7, first}, {2, second}}, physics.shapes, Communicator());
  REQUIRE(physics.shapes.size() == 7);
  CHECK(physics.shapeOf(cells[7]).mesh().vertices == first);
  CHECK(physics.shapeOf(cells[2]).mesh().vertices == second);  // it was deformed before
  for (const std::size_t cell : {2, 7}) {
    CHECK(physics.shapeOf(cells[cell]).undeformed() == physics.shapes[1]);
    CHECK(physics.areOfCell(cells[cell].species, cells[cell].shape));
  }
  for (const std::size_t cell : {0, 1, 3, 4, 5, 6}) CHECK(cells[cell].shape == result.cells[cell].shape);
}

TEST_CASE("Soft cells keep to the wall and to layers beyond what these demand", "[soft]") {
  Physics physics = cellsInTube();
  physics.wallClearance = 0.3;
  const Vec3 p(3, 0, 4);  // 1 µm from the wall
  REQUIRE(wallGapOf(physics, 0));
  CHECK((*wallGapOf(physics, 0))(p).distance == Approx(0.7));
  CHECK(((*wallGapOf(physics, 0))(p).gradient + Vec3::UnitZ()).norm() < 1e-12);
  const auto wall = std::shared_ptr<const Wall>(physics.container, physics.container->wall());
  physics.species[0].freedom.freeLayer = FreeLayer{wall, 0.9};
  CHECK((*wallGapOf(physics, 0))(p).distance == Approx(0.1));
  CHECK((*wallGapOf(physics, 1))(p).distance == Approx(0.7));
  physics.container = makeBox(Box{Vec3::Zero(), Vec3::Constant(9)}, {true, true, true});
  CHECK_FALSE(wallGapOf(physics, 1));
  CHECK(wallGapOf(physics, 0));
}

TEST_CASE("Undeformed cells at a scale are smaller, and those that do not grow stay", "[soft]") {
  const Physics physics = cellsInTube();
  const Physics small = scaledPhysics(physics, {true, false}, 0.5, 0.04, 1.0);
  CHECK(small.clearance == 0.04);
  CHECK(small.wallClearanceOf(0) == Approx(0.04));  // the distance to a cylinder is exact, and not smoothed
  CHECK(small.shapes[small.species[0].shape]->volume() == Approx(physics.shapes[0]->volume() / 8));
  CHECK(small.species[1].shape == physics.species[1].shape);
  CHECK(small.species[0].count == 3);
}

TEST_CASE("States of cells that keep to smoothed walls are told from others", "[soft]") {
  PackingProblem problem;
  problem.physics = cellsInTube();
  const std::string digest = digestOf(problem);
  problem.physics.smoothWalls = true;
  CHECK(digestOf(problem) != digest);
}
