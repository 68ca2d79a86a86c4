// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/duration.h"

#include <catch2/catch.hpp>

using packmesh::hemocell::durationText;

TEST_CASE("Durations are printed in readable units", "[duration]") {
  CHECK(durationText(0.0) == "0 s");
  CHECK(durationText(0.25) == "0.25 s");
  CHECK(durationText(9.0) == "9 s");
  CHECK(durationText(119.4) == "119 s");
  CHECK(durationText(120.0) == "2 min");
  CHECK(durationText(725.2) == "12 min 5 s");
  CHECK(durationText(7199.9) == "120 min");
  CHECK(durationText(12000.0) == "3 h 20 min");
  CHECK(durationText(172800.0) == "2 days");
  CHECK(durationText(1e9) == "32 years");
  CHECK(durationText(9.2e40) == "more than 1000 years");
}
