// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/packing_problem.h"
#include "packMesh/core/error.h"
#include "packMesh/packing/problem_digest.h"
#include "packMesh/packing/state_file.h"
#include "tests/support/catch.h"
#include "tests/support/packings.h"
#include "tests/support/temporary_folder.h"

#if PACKMESH_CAT
#include "tests/support/cat.h"
#endif

using namespace packmesh;
using test::mixtureIn;

namespace {

std::shared_ptr<const Container> longBox() {
  return makeBox({Vec3::Zero(), Vec3(55, 26, 26)}, {true, true, true});
}

struct Seen {
  std::array<int, 5> ofStage = {0, 0, 0, 0, 0};
  int annealing = 0;
  std::int64_t attempts = 0;  ///< of growth
};

/// Runs to the end, and from states on its way again. @return how many states there were
Seen requireSameWayFromAnyState(PackingProblem problem) {
  std::vector<PackingState> states;
  problem.checkpoints = Checkpoints{[] { return true; }, [&](const PackingState& s) { states.push_back(s); }};
  const PackingResult whole = pack(problem);
  problem.checkpoints.reset();
  REQUIRE(test::sameBits(whole, pack(problem)));  // saving changes nothing
  REQUIRE(states.size() >= 3);

  const test::TemporaryFolder folder;
  Seen stages;
  const PackingState* before = nullptr;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Stage stage = states[i].position.stage;
    const int seen = stages.ofStage[int(stage)]++;
#if PACKMESH_CAT
    if (const auto* of = dynamic_cast<const CatState*>(states[i].engine.get()))
      stages.attempts = std::max(stages.attempts, of->attempt + 1);
#endif
    stages.annealing += states[i].position.schedule.part > 0;
    const bool newPart = before && before->position.schedule.part != states[i].position.schedule.part;
    before = &states[i];
    if (seen > 1 && !newPart && i % (1 + states.size() / 3) != 0 && i + 1 != states.size()) continue;
    CAPTURE(i, int(stage), states[i].position.round, states[i].relaxation.sweeps);
    writeState(folder.path() / "state.h5", problem, {"by hand", {}, ""}, states[i]);
    problem.resume = readState(folder.path() / "state.h5", problem);
    const PackingResult rest = pack(problem);
    REQUIRE(rest.outcome == whole.outcome);
    REQUIRE(rest.certificate.clean());
    REQUIRE(rest.cellCount == whole.cellCount);
    REQUIRE(test::sameBits(rest, whole));
    REQUIRE(rest.statistics.sweeps == whole.statistics.sweeps);
    REQUIRE(rest.statistics.repairs == whole.statistics.repairs);
    REQUIRE(rest.certificate.minimumGap == whole.certificate.minimumGap);
  }
  return stages;
}

/// Red cells in a small periodic box in which some have their places already.
PackingProblem besideFixedCells(std::int64_t count, std::uint64_t seed) {
  PackingProblem few = test::redCellProblem(test::periodicCube(16.0), 0.0, seed);
  few.physics.species[0].count = 6;
  PackingProblem problem = few;
  problem.physics.add("fixed", test::redCellShape(), 6);
  problem.physics.species[0].count = count;
  problem.physics.species[1].start = pack(few).poses;
  problem.physics.species[1].freedom.fixed = true;
  return problem;
}

int of(const Seen& seen, Stage stage) {
  return seen.ofStage[int(stage)];
}

}  // namespace

TEST_CASE("A run continued from any of its states gives the same result as an uninterrupted one") {
  SECTION("repairs") {
    int relaxing = 0, repairing = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const Seen seen = requireSameWayFromAnyState(mixtureIn(longBox(), 0.55, seed));
      relaxing += of(seen, Stage::relaxation);
      repairing += of(seen, Stage::repair);
    }
    REQUIRE(relaxing > 4);
    REQUIRE(repairing > 0);
  }
#if PACKMESH_CAT
  SECTION("growth") {
    PackingProblem problem = mixtureIn(test::periodicCube(18.0), 0.5, 3);
    test::useCat(problem);
    REQUIRE(of(requireSameWayFromAnyState(problem), Stage::engine) > 5);
  }
#endif
}

TEST_CASE("A run continued from any of its states gives the same result, in vessels, annealing and escaping",
          "[long]") {
  SECTION("walls, clearances, cells that do not rotate") {
    PackingProblem problem = mixtureIn(makeCylinder(Vec3::Zero(), 0, 12.0, 60.0, false), 0.2, 3);
    problem.physics.clearance = 0.1;
    problem.physics.wallClearance = 0.2;
    problem.physics.rotate = false;
    requireSameWayFromAnyState(problem);
  }
  SECTION("cells that meet the wall") {
    requireSameWayFromAnyState(mixtureIn(makeSphere(Vec3::Zero(), 13.0), 0.45, 4));
  }
  SECTION("annealing, and then fewer cells") {
    PackingProblem problem = mixtureIn(test::periodicCube(25.0), 0.63, 6);
    problem.execution.limits.maxSweeps = 330;
    const Seen seen = requireSameWayFromAnyState(problem);
    REQUIRE(seen.annealing > 1);
  }
#if PACKMESH_CAT
  SECTION("growth with tetrahedra, and attempts in vain") {
    PackingProblem problem = mixtureIn(makeSphere(Vec3::Zero(), 6.5), 0.62, 5);
    CatSettings& cat = test::useCat(problem);
    cat.planeSource = PlaneSource::catFaces;
    problem.execution.limits.maxSweeps = 100;
    cat.growth.maxIterations = 4;
    cat.escape.emplace();
    const Seen seen = requireSameWayFromAnyState(problem);
    REQUIRE(of(seen, Stage::engine) > 4);
    REQUIRE(seen.attempts > 1);
  }
#endif
}

TEST_CASE("An interrupted run leaves the last saved state") {
  PackingProblem problem = mixtureIn(longBox(), 0.5, 2);
  const PackingResult whole = pack(problem);
  for (const int polls : {0, 8, 25, 200}) {
    CAPTURE(polls);
    int left = polls;
    problem.execution.interrupted = [&] { return left-- <= 0; };
    std::vector<PackingState> states;
    problem.checkpoints = Checkpoints{{}, [&](const PackingState& s) { states.push_back(s); }};
    problem.resume.reset();
    REQUIRE(pack(problem).outcome == Outcome::interrupted);
    if (polls == 0) {  // before cells were placed
      REQUIRE(states.empty());
      continue;
    }
    REQUIRE(states.size() == 1);
    REQUIRE(states[0].cellCount == whole.cellCount);
    problem.execution.interrupted = {};
    problem.checkpoints.reset();
    problem.resume = states[0];
    REQUIRE(test::sameBits(pack(problem), whole));
  }
}

TEST_CASE("An infeasible run continues with higher limits") {
  PackingProblem problem = mixtureIn(longBox(), 0.5, 2);
  const PackingResult whole = pack(problem);
  REQUIRE(whole.outcome == Outcome::certified);
  PackingState last;
  problem.checkpoints = Checkpoints{{}, [&](const PackingState& state) { last = state; }};
  problem.execution.limits.maxSweeps = whole.statistics.sweeps / 2;
  REQUIRE(pack(problem).outcome == Outcome::outOfReach);
  REQUIRE(last.cellCount == whole.cellCount);
  problem.resume = last;
  SECTION("relaxation: with the same they end the same") {
    REQUIRE(pack(problem).outcome == Outcome::outOfReach);
  }
  SECTION("relaxation: to the same packing") {
    problem.execution.limits = {};
    REQUIRE(test::sameBits(pack(problem), whole));
  }
  SECTION("unless the fewer cells are what is wanted") {
    problem.resume.reset();
    problem.checkpoints->endsWithFewer = true;
    const PackingResult fewer = pack(problem);
    REQUIRE(last.cellCount == fewer.cellCount);
    REQUIRE(last.cellCount < whole.cellCount);
    problem.resume = last;
    problem.checkpoints.reset();
    REQUIRE(test::sameBits(pack(problem), fewer));
  }
}

TEST_CASE("Only cells of a result are measured") {
  PackingProblem problem = mixtureIn(longBox(), 0.5, 2);
  bool finished = false;
  problem.checkpoints =
      Checkpoints{{}, [&](const PackingState& state) { finished = isFinished(state, Communicator()); }, true};
  SECTION("all cells") {
    REQUIRE(pack(problem).outcome == Outcome::certified);
    REQUIRE(finished);
  }
  SECTION("time is over before fewer cells are certified") {
    int looks = 0;
    problem.execution.limits.clock = [&] { return ++looks < 12 ? 0.0 : 1e9; };
    problem.execution.limits.maxSeconds = 1.0;
    const PackingResult result = pack(problem);
    REQUIRE(result.outcome == Outcome::outOfReach);
    REQUIRE(result.cellCount == 0);
    REQUIRE_FALSE(finished);
  }
}

TEST_CASE("All cells leave a finished state, however they were found") {
  const std::int64_t count = GENERATE(16, 21);  // at once; by the search for the densest packing
  const auto seed = GENERATE(std::uint64_t(3), std::uint64_t(4), std::uint64_t(5));
  CAPTURE(count, seed);
  PackingProblem problem = besideFixedCells(count, seed);
  double now = 0.0;
  problem.execution.progress = [&](const Progress&) { now += 0.01; };
  problem.execution.limits.clock = [&] { return now; };
  problem.execution.limits.maxSeconds = 20.0;
  PackingState last;
  problem.checkpoints = Checkpoints{{}, [&](const PackingState& state) { last = state; }};
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::certified);
  REQUIRE((result.statistics.searching > 0) == (count == 21));
  REQUIRE(isFinished(last, Communicator()));
  REQUIRE(last.cellCount == problem.physics.cellCount());
  problem.resume = last;
  REQUIRE(test::sameBits(pack(problem), result));
}

#if PACKMESH_CAT
TEST_CASE("Infeasible growth continues with higher limits") {
  PackingProblem problem = mixtureIn(test::periodicCube(18.0), 0.3, 3);
  test::useCat(problem);
  const PackingResult whole = pack(problem);
  REQUIRE(whole.outcome == Outcome::certified);
  PackingState last;
  problem.checkpoints = Checkpoints{{}, [&](const PackingState& state) { last = state; }};
  problem.execution.limits.maxSweeps = whole.statistics.effort() / 2;
  REQUIRE(pack(problem).outcome == Outcome::outOfReach);
  problem.resume = last;
  problem.execution.limits = {};
  REQUIRE(test::sameBits(pack(problem), whole));
}
#endif

TEST_CASE("A run can be interrupted in any stage and leaves a state of that stage") {
  // False when the run had no such stage.
  const auto interruptedIn = [](PackingProblem problem, Stage wanted) {
    PackingState last;
    bool reached = false;
    problem.checkpoints = Checkpoints{[&] { return !reached; },
                                      [&](const PackingState& state) {
                                        last = state;
                                        reached = reached || state.position.stage == wanted;
                                      }};
    problem.execution.interrupted = [&] { return reached; };
    const PackingResult result = pack(problem);
    if (!reached) return false;
    CAPTURE(int(wanted));
    REQUIRE(result.outcome == Outcome::interrupted);
    REQUIRE(result.cells.empty());
    REQUIRE(last.position.stage == wanted);
    return true;
  };
  CHECK(interruptedIn(mixtureIn(longBox(), 0.55, 1), Stage::relaxation));
  CHECK(interruptedIn(mixtureIn(longBox(), 0.55, 1), Stage::certificate));
  int repaired = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
    repaired += interruptedIn(mixtureIn(longBox(), 0.55, seed), Stage::repair);
  CHECK(repaired > 0);
#if PACKMESH_CAT
  PackingProblem grown = mixtureIn(test::periodicCube(18.0), 0.5, 3);
  test::useCat(grown);
  CHECK(interruptedIn(grown, Stage::engine));
#endif
}

TEST_CASE("Problems are distinguished by everything that determines the packing and by nothing else") {
  const auto sample = [] { return mixtureIn(longBox(), 0.3, 1); };
  const std::string digest = digestOf(sample());
  REQUIRE(digest.size() == 32);
  const auto differs = [&](auto&& change) {
    PackingProblem problem = sample();
    change(problem);
    return digestOf(problem) != digest;
  };
  REQUIRE_FALSE(differs([](PackingProblem&) {}));
  REQUIRE_FALSE(differs([](PackingProblem& p) { p.execution.limits.maxSweeps = 7; }));
  REQUIRE(differs([](PackingProblem& p) { p.physics.seed = 2; }));
  REQUIRE(differs([](PackingProblem& p) { p.physics.clearance = 0.1; }));
  REQUIRE(differs([](PackingProblem& p) { p.physics.wallClearance = 0.1; }));
  REQUIRE(differs([](PackingProblem& p) { p.physics.rotate = false; }));
  REQUIRE(differs([](PackingProblem& p) { ++p.physics.species[1].count; }));
  REQUIRE(differs([](PackingProblem& p) { p.physics.species[1].name = "ball"; }));
  REQUIRE(differs([](PackingProblem& p) { p.physics.shapes[1] = test::sphereShape(1.01); }));
  REQUIRE(differs([](PackingProblem& p) {
    p.physics.container = makeBox({Vec3::Zero(), Vec3(55, 26, 26.001)}, {true, true, true});
  }));
  REQUIRE(differs([](PackingProblem& p) {
    p.physics.container = makeBox({Vec3::Zero(), Vec3(55, 26, 26)}, {true, true, false});
  }));
}

TEST_CASE("A run continued from any readable state ends with a certificate", "[long]") {
  const bool growing = GENERATE(false, true);
  PackingProblem problem = mixtureIn(test::periodicCube(growing ? 14.0 : 20.0), growing ? 0.3 : 0.5, 3);
#if PACKMESH_CAT
  if (growing) test::useCat(problem);
#endif
  problem.execution.limits.maxSweeps = 400;
  std::vector<PackingState> states;
  problem.checkpoints = Checkpoints{[] { return true; }, [&](const PackingState& s) { states.push_back(s); }};
  pack(problem);
  problem.checkpoints.reset();

  std::mt19937_64 random(17);
  const auto oneOf = [&](const auto& values) { return values[random() % values.size()]; };
  const auto number = [&] {
    return oneOf(std::vector<std::int64_t>{0, 1, 2, 7, 299, 1000, 1000000, std::int64_t(1) << 40});
  };
  const auto length = [&] {
    return oneOf(std::vector<double>{0.0, 1e-300, 1e-9, 0.01, 1.0, 30.0, 1e6, 1e16});
  };
  const auto cell = [&](PackingState& s) -> BodyState& { return s.cells[random() % s.cells.size()]; };
  const auto id = [&] { return std::int64_t(random() % states[0].cells.size()); };
  std::vector<std::function<void(PackingState&)>> changes = {
      [&](PackingState& s) { s.position.stage = static_cast<Stage>(random() % (growing ? 4 : 3)); },
      [&](PackingState& s) { s.position.fewer = !s.position.fewer; },
      [&](PackingState& s) { s.position.round = number(); },
      [&](PackingState& s) {
        s.position.schedule = {number(), number()};
      },
      [&](PackingState& s) { s.repairs = number(); },
      [&](PackingState& s) { s.relaxation.sweeps = number(); },
      [&](PackingState& s) { s.relaxation.listedInSweep = number(); },
      [&](PackingState& s) {
        s.relaxation.counts = {number(), number()};
      },
      [&](PackingState& s) { s.relaxation.blocks[random() % 3] = int(number()); },
      [&](PackingState& s) { s.relaxation.skin = length(); },
      [&](PackingState& s) { s.relaxation.slack = length(); },
      [&](PackingState& s) { s.relaxation.coarsely = !s.relaxation.coarsely; },
      [&](PackingState& s) { s.relaxation.last.contacts = number(); },
      [&](PackingState& s) { s.relaxation.last.totalSteps = number(); },
      [&](PackingState& s) { s.relaxation.last.deepest = length(); },
      [&](PackingState& s) { s.relaxation.last.thorough = !s.relaxation.last.thorough; },
      [&](PackingState& s) {
        s.relaxation.extraClearance[{id(), id()}] = float(length());
      },
      [&](PackingState& s) {
        s.relaxation.extraClearance[{number(), id()}] = 1.0f;
      },
      [&](PackingState& s) { s.relaxation.disturbed.insert(number()); },
      [&](PackingState& s) {
        s.failures[{id(), number()}] = number();
      },
      [&](PackingState& s) { s.demandedOfWall[number()] = length(); },
      [&](PackingState& s) { cell(s).species = int(random() % 3); },
      [&](PackingState& s) { cell(s).scale = length(); },
      [&](PackingState& s) { cell(s).position[random() % 3] = length(); },
      [&](PackingState& s) { cell(s).extraWallClearance = length(); },
      [&](PackingState& s) { cell(s).overlap = length(); },
      [&](PackingState& s) { cell(s).moved = length(); },
      [&](PackingState& s) {
        s.cells.erase(s.cells.begin() + std::ptrdiff_t(random() % s.cells.size()));
        --s.cellCount;
      },
      [&](PackingState& s) { cell(s).stepTaken = length(); },
  };
#if PACKMESH_CAT
  const auto changeOfEngine = [&](auto change) {
    changes.push_back([&cell, change](PackingState& s) {
      const auto* const of = dynamic_cast<const CatState*>(s.engine.get());
      if (!of) return;
      auto changed = std::make_shared<CatState>(*of);
      change(*changed, cell(s));
      s.engine = changed;
    });
  };
  changeOfEngine([&](CatState& s, const BodyState&) { s.done = number(); });
  changeOfEngine([&](CatState& s, const BodyState&) { s.attempt = number(); });
  changeOfEngine([&](CatState& s, const BodyState&) {
    GrowthProgress& at = s.at;
    *std::array{&at.barrier, &at.iteration, &at.since, &at.failures}[random() % 4] = number();
  });
  changeOfEngine([&](CatState& s, const BodyState&) { s.at.sweeps = length(); });
  changeOfEngine([&](CatState& s, const BodyState&) { s.at.reference = number(); });
  changeOfEngine([&](CatState& s, const BodyState& one) { s.best.assign(2, one); });
  changeOfEngine([&](CatState& s, const BodyState& one) {
    s.best.assign(2, one);
    s.best[1].species = int(random() % 4) - 1;
  });
#endif
  const test::TemporaryFolder folder;
  int refused = 0, certified = 0;
  for (int run = 0; run < (growing ? 60 : 160); ++run) {
    PackingState changed = states[random() % states.size()];
    std::vector<std::size_t> made(1 + random() % 3);
    for (std::size_t& change : made) changes[change = random() % changes.size()](changed);
    CAPTURE(growing, run, made);
    writeState(folder.path() / "state.h5", problem, {"by hand", {}, ""}, changed);
    try {
      problem.resume = readState(folder.path() / "state.h5", problem);
    } catch (const InputError&) {
      ++refused;
      continue;
    }
    PackingResult result;
    try {
      result = pack(problem);
    } catch (const InputError& error) {  // growth looks at what it begins with
      REQUIRE_THAT(error.what(), Contains("before growth"));
      continue;
    }
    REQUIRE(result.certificate.cells == result.cellCount);
    // Out of reach, growth may leave what met in the beginning; nobody writes what has no clean certificate.
    if (!growing || result.outcome == Outcome::certified) REQUIRE(result.certificate.clean());
    certified += result.outcome == Outcome::certified;
  }
  CHECK(refused > 10);
  CHECK(certified > 15);
}

TEST_CASE(
    "The end of a run that is continued from its end has the same measures, which are not taken again") {
  PackingProblem problem = mixtureIn(longBox(), 0.4, 1);
  PackingState last;
  std::vector<PackingState> states;
  problem.checkpoints = Checkpoints{[] { return true; },
                                    [&](const PackingState& s) {
                                      last = s;
                                      states.push_back(s);
                                    }};
  pack(problem);
  const std::vector<double> measured = last.measures.gap;
  REQUIRE(measured.size() == last.cells.size());
  REQUIRE(measured.size() > 100);

  problem.resume = last;
  problem.resume->measures.gap[5] += 0.25;  // to be recognised
  pack(problem);
  CHECK(last.measures.gap[5] == measured[5] + 0.25);

  SECTION("unless they are unknown") {
    problem.resume->measures.gap[7] = std::nan("");
  }
  SECTION("unless cells have moved since") {
    problem.resume = states.front();
    problem.resume->measures = last.measures;
  }
  pack(problem);
  CHECK(last.measures.gap[5] == measured[5]);
}
