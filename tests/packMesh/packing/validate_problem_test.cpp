// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/validate_problem.h"

#include <array>
#include <catch2/catch.hpp>
#include <limits>
#include <string>

#include "packMesh/core/error.h"
#include "tests/support/packings.h"

using namespace packmesh;
using Catch::Contains;
using test::periodicCube;
using test::redCellProblem;

TEST_CASE("Invalid problems are rejected with a reason", "[packing]") {
  PackingProblem problem = redCellProblem(periodicCube(25.0), 0.40);
  REQUIRE_NOTHROW(validate(problem));

  SECTION("no container") {
    problem.physics.container = nullptr;
    REQUIRE_THROWS_WITH(validate(problem), Contains("no container"));
  }
  SECTION("periods that are much smaller than a cell") {
    problem = redCellProblem(makeBox({Vec3::Zero(), Vec3(0.2, 100.0, 100.0)}, {true, true, true}), 0.1);
    REQUIRE_THROWS_WITH(validate(problem), Contains("the period of the lumen, 0.2 µm along x, is too small"));
  }
  SECTION("no shape") {
    problem.physics.shapes[0] = nullptr;
    REQUIRE_THROWS_WITH(validate(problem), Contains("species 'RBC' has no shape"));
  }
  SECTION("negative count") {
    problem.physics.species[0].count = -3;
    REQUIRE_THROWS_WITH(validate(problem), Contains("species 'RBC' has a negative count, -3"));
  }
  SECTION("clearances") {
    problem.physics.clearance = -0.1;
    REQUIRE_THROWS_WITH(validate(problem), Contains("clearance between cells") && Contains("found -0.1"));
    problem.physics.clearance = std::numeric_limits<double>::quiet_NaN();
    REQUIRE_THROWS_WITH(validate(problem), Contains("clearance between cells"));
    problem.physics.clearance = 0.0;
    problem.physics.wallClearance = std::numeric_limits<double>::infinity();
    REQUIRE_THROWS_WITH(validate(problem), Contains("clearance to the wall"));
    problem.physics.wallClearance = -1e-9;
    REQUIRE_THROWS_WITH(validate(problem), Contains("clearance to the wall"));
  }
  SECTION("more cells than lumen") {
    problem.physics.species[0].count = 250;
    REQUIRE_THROWS_WITH(validate(problem), Contains("more volume than the lumen"));
    REQUIRE_THROWS_AS(pack(problem), InputError);
  }
  SECTION("a cell larger than the lumen") {
    problem.physics.container = makeCylinder(Vec3::Zero(), 0, 0.5, 200.0, true);
    problem.physics.species[0].count = 1;
    REQUIRE_THROWS_WITH(validate(problem), Contains("species 'RBC'") && Contains("larger than the lumen") &&
                                               Contains("cylinder"));
  }
  SECTION("a clearance to the wall that leaves no room") {
    problem.physics.container = makeBox(Box{Vec3::Zero(), Vec3(4.0, 30.0, 30.0)}, {false, true, true});
    problem.physics.species[0].count = 1;
    REQUIRE_NOTHROW(validate(problem));
    problem.physics.wallClearance = 1.9;
    REQUIRE_THROWS_WITH(validate(problem), Contains("larger than the lumen"));
  }
  SECTION("species that are not wanted may be of any size") {
    problem.physics.container = periodicCube(8.0);
    problem.physics.species[0].count = 1;
    problem.physics.add("rock", test::sphereShape(50.0), 0);
    REQUIRE_NOTHROW(validate(problem));
  }
}

TEST_CASE("cellVolume includes the cells of all species", "[packing]") {
  PackingProblem problem = redCellProblem(periodicCube(25.0), 0.40);
  const auto sphere = test::sphereShape(1.0);
  problem.physics.add("sphere", sphere, 7);
  REQUIRE(cellVolume(problem) ==
          Approx(problem.physics.species[0].count * test::redCellShape()->volume() + 7.0 * sphere->volume()));
}
