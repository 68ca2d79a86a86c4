// SPDX-License-Identifier: AGPL-3.0-or-later
// Sessions, without a process: what they make, hand out and refuse.
#include "hemocell_adapter/session/session.h"

#include <catch2/catch.hpp>

#include "hemocell_adapter/base/agreed_failure.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/output/requested_outputs.h"
#include "hemocell_adapter/settings/command_line.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using Catch::Matchers::Contains;

namespace {

/// A session of a request, which prints nothing.
class Quiet {
 public:
  explicit Quiet(const std::vector<std::string>& words, const Hooks& hooks = {})
      : completed(requestToPack(parseCommandLine("packMesh", words).request)),
        output(outputsToPack(completed)),
        session(returnedToPython, hooks, ranks) {
    log::setLevel(log::Level::silent);
  }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;
  ~Quiet() { log::setLevel(log::Level::normal); }

  Packing pack() { return session.pack(session.prepare(completed), output); }

  /// The failure of a packing that is not handed out.
  AgreedFailure failure() {
    try {
      pack();
    } catch (const AgreedFailure& failure) {
      return failure;
    }
    FAIL("it was packed");
    throw;
  }

  const CompletedRequest completed;
  const OutputRequest output;
  const Communicator ranks;
  Session session;
};

}  // namespace

TEST_CASE("A session hands out a packing that is certified, counted and kept by HemoCell", "[session]") {
  Quiet quiet({"16", "16", "16", "--rbc", "6", "--plt", "2", "--seed", "3"});
  const Packing packing = quiet.pack();
  CHECK(packing.outcome == Outcome::certified);
  CHECK(packing.certificate.clean());
  CHECK(packing.tally.counts == std::vector<std::int64_t>{6, 2});
  CHECK(packing.kept.kept == packing.tally.counts);
  CHECK(packing.kept.reasons.empty());
  CHECK_FALSE(packing.state);
  CHECK_FALSE(packing.before);
  CHECK(packing.packed.clearances.membranes > 0.0);  // more than demanded, where that is possible
}

TEST_CASE("A packing has its state if one is requested, which is not written by the session", "[session]") {
  const test::TemporaryFolder folder;
  Quiet quiet({"16", "16", "16", "--rbc", "4", "--state", (folder.path() / "new" / "s.h5").string()});
  const Packing packing = quiet.pack();
  CHECK(packing.state);
  CHECK(std::filesystem::is_directory(folder.path() / "new"));
  CHECK(std::filesystem::is_empty(folder.path() / "new"));
}

TEST_CASE("A packing that is repeated has the one before, and is of a larger box", "[session]") {
  Quiet quiet({"12", "12", "12", "--rbc", "3", "--ends", "periodic", "--tile", "2", "1", "1"});
  const Packing packing = quiet.pack();
  REQUIRE(packing.before);
  CHECK(packing.before->cellCount == 3);
  CHECK(packing.cellCount == 6);
  CHECK(packing.problem->lumen.container->bounds().hi.x() == Approx(24.0));
}

TEST_CASE("With a profile a session packs before it hands out a problem", "[session]") {
  Quiet quiet(
      {"--cylinder", "x", "9", "30", "--ends", "periodic", "--hematocrit", "0.2", "--profile", "developed"});
  const Problem first = problemToPack(quiet.completed);
  const std::shared_ptr<const Problem> prepared = quiet.session.prepare(quiet.completed);
  REQUIRE(prepared->layout.profile);
  CHECK(prepared->layout.profile->species[0].weight != first.layout.profile->species[0].weight);
  CHECK(prepared->mostCells() == first.mostCells());
}

TEST_CASE("What cannot be packed is not handed out, unless fewer cells are enough", "[session]") {
  const std::vector<std::string> dense = {"12",          "12", "12",     "--hematocrit", "0.68",
                                          "--plt_ratio", "0",  "--ends", "periodic",     "--max-iterations",
                                          "60"};
  const AgreedFailure failure = Quiet(dense).failure();
  CHECK(failure.code() == ExitCode::outOfReach);
  CHECK_THAT(failure.what(), Contains("not feasible within the limits") && Contains("no cells are returned"));
  std::vector<std::string> content = dense;
  content.push_back("--best-effort");
  Quiet quiet(content);
  const Packing packing = quiet.pack();
  CHECK(packing.outcome == Outcome::outOfReach);
  CHECK(packing.cellCount > 0);
  CHECK(packing.cellCount < packing.problem->mostCells());
  CHECK(packing.certificate.clean());
}

TEST_CASE("An interrupted session hands out nothing", "[session]") {
  Hooks hooks;
  hooks.interrupted = [] { return true; };
  const AgreedFailure failure = Quiet({"16", "16", "16", "--rbc", "6"}, hooks).failure();
  CHECK(failure.code() == ExitCode::interrupted);
}

TEST_CASE("The end of preparation owns what it needs", "[session]") {
  std::function<void()> unlimited, limited, interrupted;
  {
    const Delivery delivery = writtenToFiles;
    unlimited = endOfPreparation(0.0, delivery);
    limited = endOfPreparation(1e-9, delivery);
    interrupted = endOfPreparation(0.0, delivery, [] { return true; });
  }
  CHECK_NOTHROW(unlimited());
  CHECK_THROWS_WITH(limited(), Contains("was reached before packing began; nothing was written"));
  CHECK_THROWS_WITH(interrupted(), Contains("interrupted: nothing was written"));
}
