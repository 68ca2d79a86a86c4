// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/regrowth.h"

#include <catch2/catch.hpp>

#include "packMesh/growth/plane_builder.h"
#include "tests/support/packings.h"

using namespace packmesh;

namespace {

struct Packed {
  PackingProblem problem;
  GrowthScene scene;
  GrowthState state;
  TetrahedraSums tetrahedra;

  Packed(const std::shared_ptr<const Container>& container, double fraction)
      : problem(test::redCellProblem(container, fraction)) {
    scene.shapes = {problem.species[0].shape.get()};
    scene.walls = {container->wall()};
    scene.container = container.get();
    for (const Pose& pose : pack(problem).poses) state.push_back({0, pose});
  }
  BuilderFactory factory(Builder builder = Builder::chords) {
    return [this, builder](const GrowthScene& part) { return makeBuilder(builder, part, tetrahedra); };
  }
  Certificate faults() const { return StepBack(scene).examine(state); }
  bool valid() const { return faults().clean(); }
};

std::size_t changedCells(const GrowthState& a, const GrowthState& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    count += a[i].pose.position != b[i].pose.position || a[i].pose.scale != b[i].pose.scale ||
             a[i].pose.orientation.coeffs() != b[i].pose.orientation.coeffs();
  return count;
}

}  // namespace

TEST_CASE("Cells that meet after relaxation are shrunk and grow again, others stay") {
  for (const Builder builder : {Builder::chords, Builder::tetgen}) {
    Packed packed(test::periodicCube(20.0), 0.40);
    REQUIRE(packed.valid());
    // Pushes a cell into the nearest other one.
    std::size_t other = 1;
    const Vec3 at = packed.state[0].pose.position;
    for (std::size_t i = 1; i < packed.state.size(); ++i)
      if ((packed.state[i].pose.position - at).norm() < (packed.state[other].pose.position - at).norm())
        other = i;
    const Vec3 direction = (packed.state[other].pose.position - at).normalized();
    for (double push = 0.05; packed.valid(); push += 0.05)
      packed.state[0].pose.position = at + push * direction;
    const GrowthState before = packed.state;
    RegrowthSums sums;
    REQUIRE(regrow(packed.scene, packed.problem.growth, packed.factory(builder), {}, packed.faults(),
                   packed.state, sums));
    CHECK(packed.valid());
    for (const GrowingCell& cell : packed.state) CHECK(cell.pose.scale == 1.0);
    CHECK(sums.rounds == 1);
    CHECK(sums.cells >= 2);
    CHECK(sums.smallest < 1.0);
    CHECK(sums.clusters >= 1);
    CHECK(sums.unfinished == 0);
    CHECK(sums.growth.iterations > 0);
    CHECK(changedCells(before, packed.state) < packed.state.size() / 2);
    CHECK((builder == Builder::tetgen) == (packed.tetrahedra.runs > 0));
  }
}

TEST_CASE("What cannot grow again leaves the state as it was") {
  // Two spheres in a sphere that is a little too small for them.
  Packed packed(test::periodicCube(14.0), 0.20);
  const auto sphere = test::sphereShape(1.0);
  const auto lumen = makeSphere(Vec3::Zero(), 1.99);
  packed.scene.shapes = {sphere.get()};
  packed.scene.walls = {lumen->wall()};
  packed.scene.container = lumen.get();
  packed.state = {{0, Pose{1.0, Quaternion::Identity(), Vec3(0.985, 0.0, 0.0)}},
                  {0, Pose{1.0, Quaternion::Identity(), Vec3(-0.985, 0.0, 0.0)}}};
  const GrowthState before = packed.state;
  RegrowthSums sums;
  CHECK_FALSE(
      regrow(packed.scene, packed.problem.growth, packed.factory(), {}, packed.faults(), packed.state, sums));
  CHECK(changedCells(before, packed.state) == 0);
  CHECK(sums.unfinished + (sums.cells == 0) > 0);
}

TEST_CASE("Local growth: alone up to the surfaces of the neighbours, or with them making way") {
  Packed packed(test::periodicCube(16.0), 0.35);
  for (const MakingWay way : {MakingWay::nobody, MakingWay::neighbours}) {
    GrowthState state = packed.state;
    state[3].pose.scale = 0.7;
    const GrowthState before = state;
    LocalGrowth growth(packed.scene, packed.problem.growth, packed.factory());
    GrowthStatistics statistics;
    CHECK(growth.grow({3}, way, {}, state, statistics));
    CHECK(state[3].pose.scale == 1.0);
    CHECK(StepBack(packed.scene).examine(state).clean());
    const std::size_t changed = changedCells(before, state);
    if (way == MakingWay::nobody) CHECK(changed == 1);
    if (way == MakingWay::neighbours) CHECK(changed <= 1 + growth.neighboursOf({3}, before, 0.0).size());
  }
}
