// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/rooms.h"

#include "packMesh/cat/cat_face_planes.h"
#include "tests/support/catch.h"
#include "tests/support/growing.h"
#include "tests/support/packings.h"

using namespace packmesh;

namespace {

struct Packed {
  PackingProblem problem;
  Execution execution;
  std::vector<Body> state;
  TetrahedraSums tetrahedra;

  Packed(const std::shared_ptr<const Container>& container, double fraction)
      : problem(test::redCellProblem(container, fraction)), state(test::bodiesAt(pack(problem).poses)) {}
  PlaneFunctionFactory factory(PlaneSource planeSource = PlaneSource::chords) {
    return [this, planeSource] {
      return makePlaneFunction(planeSource, problem.physics, execution, tetrahedra);
    };
  }
};

std::size_t changedCells(const std::vector<Body>& a, const std::vector<Body>& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    count += a[i].position != b[i].position || a[i].scale != b[i].scale ||
             a[i].orientation.coeffs() != b[i].orientation.coeffs();
  return count;
}

}  // namespace

TEST_CASE("Local growth enlarges a cell up to the surfaces of its fixed neighbours") {
  Packed packed(test::periodicCube(16.0), 0.35);
  for (const PlaneSource planeSource : {PlaneSource::chords, PlaneSource::catFaces}) {
    std::vector<Body> state = packed.state;
    state[3].scale = 0.7;
    const std::vector<Body> before = state;
    LocalGrowth growth(packed.problem.physics, packed.execution, GrowthSettings(),
                       packed.factory(planeSource));
    GrowthStatistics statistics;
    CHECK(growth.grow({3}, {}, state, statistics));
    CHECK(state[3].scale == 1.0);
    CHECK(test::examine(packed.problem.physics, state).clean());
    CHECK(changedCells(before, state) == 1);
    CHECK((planeSource == PlaneSource::catFaces) == (packed.tetrahedra.runs > 0));
  }
}
