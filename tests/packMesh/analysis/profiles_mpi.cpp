// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/analysis/profiles.h"

#include "packMesh/analysis/cell_measures.h"
#include "packMesh/packing/packing_problem.h"
#include "tests/support/catch.h"
#include "tests/support/packings.h"

using namespace packmesh;

namespace {

struct Found {
  CellMeasures cells;
  PackingMeasures all;
};

Found measured(const PackingProblem& problem, const std::vector<PlacedCell>& cells) {
  Found found{measureShare(problem.physics, problem.execution, cells), {}};
  found.all =
      measurePacking(problem.physics, problem.execution, cells, found.cells.gap, {true, false, false});
  return found;
}

void requireSame(const Profile& a, const Profile& b) {
  REQUIRE(a.width == b.width);
  REQUIRE(a.lumen == b.lumen);
  REQUIRE(a.fraction == b.fraction);
  REQUIRE(a.error == b.error);
  REQUIRE(a.red == b.red);
}

}  // namespace

TEST_CASE("Measurements do not depend on the number of ranks", "[mpi]") {
  const bool walls = GENERATE(false, true);
  const std::shared_ptr<const Container> container =
      walls ? std::shared_ptr<const Container>(makeCylinder(Vec3::Zero(), 0, 10.0, 60.0, false))
            : makeBox({Vec3::Zero(), Vec3(40, 25, 25)}, {true, true, true});
  PackingProblem problem = test::mixtureIn(container, 0.3, 5);
  const PackingResult packed = pack(problem);
  REQUIRE(packed.outcome == Outcome::certified);
  const Found alone = measured(problem, packed.cells);

  const Communicator ranks = Communicator::world();
  problem.execution.communicator = ranks;
  const std::size_t n = packed.cells.size(), first = n * ranks.rank() / ranks.size(),
                    end = n * (ranks.rank() + 1) / ranks.size();
  const Found shared = measured(problem, {packed.cells.begin() + first, packed.cells.begin() + end});
  REQUIRE(shared.cells.gap.size() == end - first);
  for (std::size_t i = first; i < end; ++i) {
    REQUIRE(shared.cells.gap[i - first] == alone.cells.gap[i]);
    REQUIRE(shared.cells.localHematocrit[i - first] == alone.cells.localHematocrit[i]);
  }
  for (int k = 0; k < 3; ++k) requireSame(shared.all.axial[k], alone.all.axial[k]);
  REQUIRE(shared.all.wall.has_value() == walls);
  if (walls) requireSame(*shared.all.wall, *alone.all.wall);
  for (std::size_t s = 0; s < problem.physics.species.size(); ++s) {
    REQUIRE(shared.all.gaps[s].counts == alone.all.gaps[s].counts);
    REQUIRE(shared.all.gaps[s].minimum == alone.all.gaps[s].minimum);
    REQUIRE(shared.all.gaps[s].mean == alone.all.gaps[s].mean);
    REQUIRE(shared.all.orientation[s].tensor == alone.all.orientation[s].tensor);
    REQUIRE(shared.all.orientation[s].director == alone.all.orientation[s].director);
  }
}
