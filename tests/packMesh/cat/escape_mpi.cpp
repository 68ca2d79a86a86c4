// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/escape.h"

#include "tests/packMesh/cat/escape_scene.h"
#include "tests/support/catch.h"

using namespace packmesh;

TEST_CASE("Escapes in several blocks do not depend on the number of ranks", "[mpi][long]") {
  const Communicator ranks = Communicator::world();
  test::LongBox shared;
  shared.execution.communicator = ranks;
  std::vector<Body> own;
  for (const Body& cell : shared.state)
    if (cell.id % ranks.size() == ranks.rank()) own.push_back(cell);
  const std::vector<EscapePhase> phases = shared.escapeFrom(own);
  REQUIRE((own.size() < shared.state.size() || ranks.alone()));
  std::vector<Body> all = ranks.gatherAll(own);
  std::sort(all.begin(), all.end(), [](const Body& a, const Body& b) { return a.id < b.id; });
  if (ranks.rank() != 0) return;

  test::LongBox alone;
  const std::vector<EscapePhase> expected = alone.escapeFrom(alone.state);
  REQUIRE(phases.size() == expected.size());
  for (std::size_t k = 0; k < phases.size(); ++k) {
    REQUIRE(phases[k].coverage == expected[k].coverage);
    REQUIRE(phases[k].cells == expected[k].cells);
    REQUIRE(phases[k].full == expected[k].full);
    REQUIRE(phases[k].tried == expected[k].tried);
    REQUIRE(phases[k].changed == expected[k].changed);
  }
  REQUIRE(all.size() == alone.state.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    REQUIRE(all[i].id == alone.state[i].id);
    REQUIRE(all[i].species == alone.state[i].species);
    REQUIRE(all[i].scale == alone.state[i].scale);
    REQUIRE(all[i].position == alone.state[i].position);
    REQUIRE(all[i].orientation.coeffs() == alone.state[i].orientation.coeffs());
  }
}
