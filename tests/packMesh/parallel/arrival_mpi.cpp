// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/arrival.h"

#include <catch2/catch.hpp>

using namespace packmesh;

TEST_CASE("Failed ranks find out whether all others have failed, too", "[mpi]") {
  const Communicator ranks = Communicator::world();
  Arrival all(ranks), some(ranks);
  REQUIRE(all.ofAll(600.0));
  if (ranks.rank() == 0) REQUIRE(some.ofAll(0.05) == ranks.alone());
  ranks.sum(std::int64_t(1));
  if (ranks.rank() > 0) REQUIRE(some.ofAll(600.0));  // now that the first one has been there
  ranks.sum(std::int64_t(1));
  REQUIRE(Arrival(Communicator()).ofAll(0.0));
}
