// SPDX-License-Identifier: AGPL-3.0-or-later
// ClearanceSearch to pack a problem with more clearance than demanded.
#include "hemocell_adapter/session/clearance_search.h"

#include <memory>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/problem/forecast.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

namespace {

std::shared_ptr<const Problem> problemShared(const std::vector<std::string>& words) {
  return std::make_shared<const Problem>(planned(words));
}

/// Prints nothing as long as it exists.
struct SilentAttempts {
  SilentAttempts() { log::setLevel(log::Level::silent); }
  ~SilentAttempts() { log::setLevel(log::Level::normal); }
};

}  // namespace

TEST_CASE("A packing has its problem, and the parts with the clearances that its certificate refers to",
          "[attempts]") {
  const SilentAttempts silence;
  const std::shared_ptr<const Problem> problem =
      problemShared({"16", "16", "16", "--rbc", "6", "--seed", "3"});
  const OutputRequest output;
  LumenSample sample(*problem);
  ClearanceSearch search(problem, output, sample);
  const Packing packing = search.withClearances(Timer());
  CHECK(packing.problem == problem);
  CHECK(packing.outcome == Outcome::certified);
  CHECK(packing.clearance > problem->demanded.membranes);
  CHECK(packing.packed.clearances.membranes == packing.clearance);
  CHECK(packing.packed.clearances.wall == packing.wallClearance);
  CHECK(packing.certificate.minimumGap >= packing.clearance);
  CHECK(packing.packed.parts.size() == packing.counts.size());
  CHECK_FALSE(packing.state);
  CHECK_FALSE(search.savedAny());
}

TEST_CASE("One attempt packs with the clearances that it is given, or says that they are impossible",
          "[attempts]") {
  const SilentAttempts silence;
  const OutputRequest output;
  const auto problem = problemShared({"16", "16", "16", "--rbc", "4", "--walls", "xyz"});
  LumenSample sample(*problem);
  ClearanceSearch search(problem, output, sample);
  AttemptLimits all;
  all.fewerCells = false;
  CHECK_FALSE(search.packAt({0.0, 7.9}, all));
  const std::optional<PackingResult> packed = search.packAt({0.2, 0.1}, all);
  REQUIRE(packed);
  CHECK(packed->outcome == Outcome::certified);
  CHECK(packed->clearance == 0.2);
  CHECK(packed->wallClearance == 0.1);
}

TEST_CASE("The remaining time of soft cells follows from what is left and what was done", "[attempts]") {
  const SilentAttempts silence;
  const auto problem = problemShared({"16", "16", "16", "--rbc", "4", "--soft"});
  LumenSample sample(*problem);
  ProgressLog progress(*problem, sample);
  const auto at = [](std::int64_t iteration, std::int64_t left) {
    return Progress{softCellsStage, iteration, 1.0, 0.0, 0, left};
  };
  CHECK_FALSE(progress.remaining(at(10, 90), 5.0));  // the first one
  CHECK(progress.remaining(at(20, 60), 9.0) == Approx(60 * 4.0 / 10));
  CHECK(progress.remaining(at(50, 10), 25.0) == Approx(10 * 20.0 / 40));
  CHECK_THAT(progress.text(at(50, 10), 25.0), Contains("at least 5 s left"));
  CHECK_FALSE(progress.remaining(at(60, 0), 30.0));
  CHECK_FALSE(progress.remaining(at(10, 90), 31.0));  // another attempt
  CHECK(progress.remaining(at(20, 80), 41.0) == Approx(80.0));
}

TEST_CASE("An attempt that is interrupted has no cells", "[attempts]") {
  const SilentAttempts silence;
  const OutputRequest output;
  Hooks hooks;
  hooks.interrupted = [] { return true; };
  const auto problem = problemShared({"16", "16", "16", "--rbc", "4"});
  LumenSample sample(*problem);
  ClearanceSearch search(problem, output, sample, hooks);
  const Packing packing = search.withClearances(Timer());
  CHECK(packing.outcome == Outcome::interrupted);
  CHECK(packing.cells.empty());
}
