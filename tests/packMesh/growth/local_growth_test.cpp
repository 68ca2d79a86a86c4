// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/local_growth.h"

#include <catch2/catch.hpp>

#include "packMesh/growth/plane_source.h"
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
  PlaneFunctionFactory factory(PlaneSource planeSource = PlaneSource::chords) {
    return [this, planeSource](const GrowthScene& part) {
      return makePlaneFunction(planeSource, part, tetrahedra);
    };
  }
};

std::size_t changedCells(const GrowthState& a, const GrowthState& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    count += a[i].pose.position != b[i].pose.position || a[i].pose.scale != b[i].pose.scale ||
             a[i].pose.orientation.coeffs() != b[i].pose.orientation.coeffs();
  return count;
}

}  // namespace

TEST_CASE("Local growth enlarges a cell up to the surfaces of its fixed neighbours") {
  Packed packed(test::periodicCube(16.0), 0.35);
  for (const PlaneSource planeSource : {PlaneSource::chords, PlaneSource::catFaces}) {
    GrowthState state = packed.state;
    state[3].pose.scale = 0.7;
    const GrowthState before = state;
    LocalGrowth growth(packed.scene, packed.problem.growth, packed.factory(planeSource));
    GrowthStatistics statistics;
    CHECK(growth.grow({3}, {}, state, statistics));
    CHECK(state[3].pose.scale == 1.0);
    CHECK(StepHalving(packed.scene).examine(state).clean());
    CHECK(changedCells(before, state) == 1);
    CHECK((planeSource == PlaneSource::catFaces) == (packed.tetrahedra.runs > 0));
  }
}
