// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/problem/physics.h"
#include "tests/support/catch.h"
#include "tests/support/deformed.h"
#include "tests/support/shapes.h"

using namespace packmesh;

TEST_CASE("All ranks have the shapes of the cells that any of them deforms", "[mpi]") {
  const Communicator ranks = Communicator::world();
  Physics physics;
  physics.add("ball", test::sphereShape(1.0), 0);
  physics.add("RBC", test::redCellShape(), 0);
  const auto formOf = [&](int shape, int rank) {
    return test::deformed(physics.shapes[shape]->mesh(), rank);
  };
  std::vector<PlacedCell> cells(3, PlacedCell{1, 1, {}});
  cells[0] = {0, 0, {}};
  std::map<std::size_t, std::vector<Vec3>> own = {{2, formOf(1, ranks.rank())}};
  if (ranks.rank() == 0) own[0] = formOf(0, 0);
  deform(cells, own, physics.shapes, ranks);
  REQUIRE(std::int64_t(physics.shapes.size()) == 3 + ranks.size());
  CHECK(cells[1].shape == 1);
  CHECK((cells[0].shape == 0) == (ranks.rank() > 0));
  CHECK(physics.shapeOf(cells[2]).mesh().vertices == own[2]);
  for (int rank = 0; rank < ranks.size(); ++rank) {
    const Shape& form = *physics.shapes[3 + rank];  // after that of the ball
    CHECK(form.undeformed() == physics.shapes[1]);
    CHECK(form.mesh().vertices == formOf(1, rank));
  }
}
