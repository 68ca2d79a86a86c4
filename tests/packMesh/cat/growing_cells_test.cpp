// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/growing_cells.h"

#include "tests/support/catch.h"
#include "tests/support/growing.h"
#include "tests/support/packings.h"

using namespace packmesh;

TEST_CASE("Blocks are divided into compact parts of about equal numbers") {
  const PackingProblem problem = test::redCellProblem(test::periodicCube(40.0), 0.3);
  const std::vector<Body> cells = test::seeded(problem.physics, {problem.physics.species[0].count}, 0.1);
  const Execution alone;
  const GrowingCells growing(problem.physics, alone, cells, 9.0, 100);
  constexpr std::size_t most = 30;
  const auto parts = growing.partsOfBlocks(most);
  std::set<std::int64_t> seen;
  for (const std::vector<std::int64_t>& part : parts) {
    CHECK(!part.empty());
    CHECK(part.size() <= most);
    CHECK(std::is_sorted(part.begin(), part.end()));
    Box extent;
    std::set<int> blocks;
    for (const std::int64_t cell : part) {
      CHECK(seen.insert(cell).second);
      extent.add(growing.all()[cell].position);
      blocks.insert(growing.all()[cell].block);
    }
    CHECK(blocks.size() == 1);
    CHECK(extent.size().maxCoeff() < 30.0);
  }
  CHECK(seen.size() == cells.size());
  CHECK(parts.size() >= cells.size() / most);
  CHECK(growing.partsOfBlocks(cells.size()) == growing.batches(0));
}
