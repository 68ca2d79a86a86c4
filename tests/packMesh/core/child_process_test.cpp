// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/child_process.h"

#include <signal.h>
#include <unistd.h>

#include <catch2/catch.hpp>

using packmesh::ChildOutcome;
using packmesh::inChildProcess;

TEST_CASE("A child process returns the result of its work") {
  const std::string large(3'000'000, 'x');
  const ChildOutcome outcome = inChildProcess([&] { return large; }, [] { return false; });
  REQUIRE(outcome.end == ChildOutcome::End::done);
  REQUIRE((outcome.bytes == large));
  REQUIRE(inChildProcess([] { return std::string(); }, {}).end == ChildOutcome::End::done);
}

TEST_CASE("Work in a child process can be stopped at any time") {
  int polls = 0;
  const auto endless = []() -> std::string {
    for (;;) pause();
  };
  REQUIRE(inChildProcess(endless, [&] { return ++polls > 3; }).end == ChildOutcome::End::stopped);
  REQUIRE(polls == 4);
  REQUIRE(inChildProcess(endless, [] { return true; }).end == ChildOutcome::End::stopped);
}

TEST_CASE("A child process that dies is reported") {
  const auto dies = []() -> std::string {
    raise(SIGKILL);
    return "";
  };
  REQUIRE(inChildProcess(dies, [] { return false; }).end == ChildOutcome::End::died);
}
