// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/memory.h"

#include <catch2/catch.hpp>

#include "packMesh/core/error.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using Catch::Matchers::Contains;

TEST_CASE("A problem that does not fit into memory is rejected with figures") {
  const Communicator alone;
  REQUIRE(availableMemory(alone) > leastMemory(1000.0));
  REQUIRE_NOTHROW(requireMemory(1000, alone));
  REQUIRE_THROWS_AS(requireMemory(std::int64_t(1) << 60, alone), InputError);
  REQUIRE_THROWS_WITH(
      requireMemory(1'000'000'000'000'000, alone),
      Contains("not enough memory: 1000000000000000 cells take at least 9e+08 GB on each of 1 rank") &&
          Contains(" GB are left for each"));
}
