// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/checkpoints.h"

#include <catch2/catch.hpp>

using namespace packmesh::hemocell;

TEST_CASE("Checkpoints are named after the state of the result") {
  for (const char* state : {"state.h5", "a b/c.d.h5", "/folder.checkpoint/s", "s"}) {
    CAPTURE(state);
    CHECK_FALSE(isCheckpoint(state));
    CHECK(resultOf(state) == state);
    CHECK(isCheckpoint(checkpointOf(state)));
    CHECK(resultOf(checkpointOf(state)) == state);
  }
  CHECK(checkpointOf("run/state.h5") == "run/state.checkpoint.h5");
}

TEST_CASE("Deformed cells alone, whose state is always written, are no request for checkpoints") {
  Request request;
  CHECK_FALSE(savesCheckpoints(request));
  request.output.stateFile = "state.h5";
  CHECK_FALSE(savesCheckpoints(request));
  Request stated = request, timed = request, continued = request;
  stated.origins["stateFile"] = {};
  timed.output.checkpointEvery = 1.0;
  continued.restart = "state.checkpoint.h5";
  for (const Request& one : {stated, timed, continued}) CHECK(savesCheckpoints(one));
}
