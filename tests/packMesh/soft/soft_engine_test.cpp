// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/soft_engine.h"

#include "packMesh/certificate/certifier.h"
#include "packMesh/container/primitives.h"
#include "packMesh/core/error.h"
#include "packMesh/packing/pack.h"
#include "packMesh/packing/state_file.h"
#include "tests/packMesh/soft/soft_meshes.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

namespace packmesh {
namespace {

/// Red cells with as many triangles as HemoCell gives them.
PackingProblem problemIn(std::shared_ptr<const Container> lumen, int cells, std::uint64_t seed = 1) {
  PackingProblem problem;
  problem.physics.container = std::move(lumen);
  problem.physics.seed = seed;
  problem.physics.add("RBC", std::make_shared<const Shape>(sample::redCell(3)), cells);
  problem.execution.limits.maxSweeps = 20000;
  problem.execution.limits.fewerCells = false;
  return problem;
}

PackingProblem boxAt(double hematocrit, int cells, std::uint64_t seed = 1) {
  const double side = std::cbrt(cells * signedVolume(sample::redCell(3)) / hematocrit);
  return problemIn(makeBox(Box{Vec3::Zero(), Vec3::Constant(side)}, {true, true, true}), cells, seed);
}

/// Packs soft cells of all species.
PackingResult packSoft(PackingProblem problem, const SoftLimits& limits = {},
                       std::vector<SoftSpecies> species = {}) {
  problem.engine = sample::softEngine(problem, limits, std::move(species));
  return pack(problem);
}

const std::vector<Vec3>& verticesOf(const PackingResult& packed, std::size_t cell) {
  return packed.deformed->physics->shapeOf(packed.cells[cell]).mesh().vertices;
}

/// A tube whose smoothed wall is as wide as itself, while what reaches beyond another radius meets its wall.
class SteppedTube final : public Container, public Wall {
 public:
  SteppedTube(double radius, double free)
      : tube_(makeCylinder(Vec3(15, 0, 0), 0, radius, 30.0, true)),
        inner_(makeCylinder(Vec3(15, 0, 0), 0, free, 30.0, true)) {}
  Box bounds() const override { return tube_->bounds(); }
  Vec3 period() const override { return tube_->period(); }
  double volume() const override { return tube_->volume(); }
  const Wall* wall() const override { return this; }
  std::string describe() const override { return "tube"; }
  TriangleMesh surface() const override { return tube_->surface(); }
  WallDistance distance(const Vec3& p) const override { return tube_->wall()->distance(p); }
  double smoothReach() const override { return 0.2; }
  WallVerdict examine(const PlacedHierarchy& cell, double gap) const override {
    return inner_->wall()->examine(cell, gap);
  }

 private:
  std::shared_ptr<const Container> tube_, inner_;
};

TEST_CASE("a box is filled far beyond what undeformed cells can fill", "[soft]") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    PackingProblem problem = boxAt(0.8, 8, seed);
    problem.physics.clearance = 0.02;
    const PackingResult packed = packSoft(problem);
    REQUIRE(packed.outcome == Outcome::certified);
    REQUIRE(packed.cells.size() == 8);
    const SoftStatistics& reached = sample::reachedBy(packed);
    CHECK(reached.startScale < 0.9);
    CHECK(reached.scale == 1.0);
    CHECK(reached.most.force <= 10.0);
    CHECK(packed.certificate.clean());
    CHECK(packed.certificate.minimumGap > 0.02);
    // The certificate is of these cells.
    CHECK(certify(certificateInputOf(*packed.deformed->physics, packed.cells)).clean());
    CHECK(packed.deformed->physics->isDeformed(packed.cells[0]));
  }
}

TEST_CASE("cells fold in a tube that is too narrow for them", "[soft]") {
  PackingProblem problem = problemIn(makeCylinder(Vec3(15, 0, 0), 0, 2.75, 30.0, true), 2);
  problem.physics.wallClearance = 0.05;
  problem.execution.limits.maxSweeps = 200;
  CHECK(pack(problem).outcome == Outcome::outOfReach);
  problem.execution.limits.maxSweeps = 20000;
  const PackingResult packed = packSoft(problem);
  REQUIRE(packed.outcome == Outcome::certified);
  CHECK(packed.certificate.clean());
  CHECK(packed.certificate.minimumWallGap > 0.05);
}

TEST_CASE("cells keep to a smoothed wall, and are not packed where their edges meet the wall itself",
          "[soft]") {
  const auto packedIn = [](double free) {
    PackingProblem problem = problemIn(std::make_shared<const SteppedTube>(2.9, free), 2);
    problem.physics.smoothWalls = true;
    problem.execution.limits.maxSweeps = 1500;
    return packSoft(problem);
  };
  const PackingResult packed = packedIn(2.9);
  CHECK(packed.outcome == Outcome::certified);
  CHECK(sample::reachedBy(packed).startScale < 1.0);
  CHECK_FALSE(sample::reachedBy(packed).meetsWall);
  const PackingResult outside = packedIn(2.6);  // beyond the range of the barrier
  CHECK(outside.outcome == Outcome::outOfReach);
  CHECK(sample::reachedBy(outside).scale == 1.0);
  CHECK(sample::reachedBy(outside).meetsWall);
  CHECK(outside.cells.empty());
}

TEST_CASE("few cells with large forces begin elsewhere, and the best attempt counts", "[soft][long]") {
  SoftLimits once, limits;
  once.usual = once.force;
  limits.usual = 0.1;
  PackingProblem problem = boxAt(0.85, 6);
  std::vector<double> first, best;
  for (int k = 0; k < 5; ++k, ++problem.physics.seed) {
    first.push_back(sample::reachedBy(packSoft(problem, once)).most.force);
    const PackingResult packed = packSoft(problem, limits);
    CHECK(packed.outcome == Outcome::certified);
    best.push_back(sample::reachedBy(packed).most.force);
    CHECK(best.back() <= first.back());
  }
  CHECK(best != first);
  for (std::size_t a = 0; a < 5; ++a)  // the attempts of a seed are not those of another one
    for (std::size_t b = 0; b < 5; ++b) {
      if (a == b) continue;
      CHECK(best[a] != first[b]);
      CHECK(best[a] != best[b]);
    }
  problem.physics.species[0].count = 40;  // these are not few
  problem.physics.container = boxAt(0.85, 40).physics.container;
  const double many = sample::reachedBy(packSoft(problem, limits)).most.force;
  CHECK(many == sample::reachedBy(packSoft(problem, once)).most.force);
}

TEST_CASE("the pose of a deformed cell is that of the template that fits best", "[soft]") {
  const PackingResult packed = packSoft(boxAt(0.7, 6));
  REQUIRE(packed.outcome == Outcome::certified);
  const std::vector<Vec3> rest = sample::redCell(3).vertices;
  for (std::size_t i = 0; i < packed.cells.size(); ++i) {
    double squares = 0.0;
    for (std::size_t v = 0; v < rest.size(); ++v)
      squares += (verticesOf(packed, i)[v] - rest[v]).squaredNorm();
    CHECK(std::sqrt(squares / double(rest.size())) < 1.0);
    CHECK(packed.poses[i].scale == 1.0);
  }
}

TEST_CASE("fixed and rigid cells with the template of soft ones keep their shape", "[soft]") {
  PackingProblem problem = boxAt(0.65, 8);
  const Pose pose{1.0, Quaternion::Identity(), Vec3(1, 2, 3)};
  std::vector<Species>& species = problem.physics.species;
  species.resize(3, species[0]);
  species[0].count = 6;
  species[1].count = species[2].count = 1;
  species[1].freedom.fixed = true;
  species[1].start = {pose};
  const PackingResult packed = packSoft(problem, {}, {{}, {}, {{}, true}});
  REQUIRE(packed.outcome == Outcome::certified);
  REQUIRE(packed.cells.size() == 8);
  for (std::size_t i = 0; i < 8; ++i) {
    CHECK(packed.deformed->physics->isDeformed(packed.cells[i]) == (packed.cells[i].species == 0));
    if (packed.cells[i].species == 1) CHECK(packed.poses[i].position == pose.position);
  }
  CHECK(packed.certificate.clean());
}

TEST_CASE("packing soft cells ends at its limits", "[soft]") {
  SECTION("the largest force") {
    SoftLimits limits;
    limits.force = limits.aim = 0.01;
    PackingProblem problem = boxAt(0.8, 6);
    problem.execution.limits.maxSweeps = 400;
    const PackingResult packed = packSoft(problem, limits);
    CHECK(packed.outcome == Outcome::outOfReach);
    CHECK(packed.cells.empty());
    CHECK(sample::reachedBy(packed).most.force > 0.01);
    CHECK_FALSE(sample::reachedBy(packed).atRest);
    CHECK_FALSE(packed.late);
  }
  SECTION("changes of volume and area") {
    SoftLimits limits;
    (GENERATE(true, false) ? limits.volume : limits.area) = 1e-6;
    PackingProblem problem = boxAt(0.8, 6);
    problem.execution.limits.maxSweeps = 600;
    const PackingResult packed = packSoft(problem, limits);
    CHECK(packed.outcome == Outcome::outOfReach);
    CHECK(sample::reachedBy(packed).scale == 1.0);
    CHECK(sample::reachedBy(packed).most.force < limits.force);
    CHECK(limits.share(sample::reachedBy(packed).most) > 100.0);
  }
  SECTION("a lumen in which there is no room") {
    PackingProblem problem = problemIn(makeCylinder(Vec3(4, 0, 0), 0, 1.9, 8.0, true), 1);
    problem.execution.limits.maxSweeps = 400;
    const PackingResult packed = packSoft(problem);
    CHECK(packed.outcome == Outcome::outOfReach);
    CHECK(packed.cells.empty());
  }
  SECTION("on request") {
    PackingProblem problem = boxAt(0.8, 6);
    int polls = 0;
    problem.execution.interrupted = [&] { return ++polls > 60; };
    CHECK(packSoft(problem).outcome == Outcome::interrupted);
  }
  SECTION("of time") {
    PackingProblem problem = boxAt(0.8, 6);
    double seconds = 0.0;
    problem.execution.limits.clock = [&] { return seconds += 0.01; };
    problem.execution.limits.maxSeconds = 0.9;
    const PackingResult packed = packSoft(problem);
    CHECK(packed.outcome == Outcome::outOfReach);
    CHECK(packed.late);
    CHECK(sample::reachedBy(packed).done < 100);
  }
}

TEST_CASE("if fewer cells suffice, those that find no room are taken out", "[soft][long]") {
  SoftLimits limits;
  const auto packedIn = [&](PackingProblem problem) {
    problem.execution.limits.fewerCells = true;
    problem.execution.limits.maxSweeps = 600;
    return packSoft(problem, limits);
  };
  SECTION("the smallest") {
    const PackingResult packed = packedIn(boxAt(1.1, 12));
    CHECK(packed.outcome == Outcome::outOfReach);
    CHECK(sample::reachedBy(packed).scale < 1.0);
    CHECK(sample::reachedBy(packed).done == 600);
    CHECK(packed.cells.size() >= 9);
    CHECK(packed.cells.size() < 11);
    CHECK(packed.certificate.clean());
    const Membrane membrane(sample::redCell(3), {});
    for (std::size_t i = 0; i < packed.cells.size(); ++i)
      CHECK(limits.allow(deformationOf(membrane, verticesOf(packed, i))));
  }
  SECTION("the most deformed") {
    limits.area = 0.02;
    const PackingResult packed = packedIn(boxAt(0.85, 12));
    CHECK(sample::reachedBy(packed).scale == 1.0);
    CHECK(packed.cells.size() > 6);
    CHECK(packed.cells.size() < 12);
    CHECK(packed.certificate.clean());
  }
}

/// Packs to the end, and from states on the way again: read from files, the same cells.
/// @return iterations of the states
std::vector<std::int64_t> requireSameFromAnyState(PackingProblem problem, const SoftLimits& limits,
                                                  std::vector<SoftSpecies> species = {}) {
  problem.engine = sample::softEngine(problem, limits, std::move(species));
  std::vector<PackingState> states;
  int asked = 0;
  const PackingResult uninterrupted = pack(problem);
  // Asked in each iteration, and again where the state is saved.
  problem.checkpoints = Checkpoints{[&] { return ++asked % 18 == 4 || asked % 18 == 5; },
                                    [&](const PackingState& state) {
                                      if (state.position.stage == Stage::engine) states.push_back(state);
                                    }};
  const PackingResult whole = pack(problem);
  if (problem.execution.limits.fewerCells) {  // from the state before cells are taken out, too
    PackingProblem all = problem;
    all.execution.limits.fewerCells = false;
    all.checkpoints->due = {};
    pack(all);
  }
  problem.checkpoints.reset();
  REQUIRE(states.size() > 2);
  const test::TemporaryFolder folder;
  std::vector<std::int64_t> iterations;
  const auto requireSame = [&](const PackingResult& other) {
    REQUIRE(other.outcome == whole.outcome);
    const SoftStatistics &reached = sample::reachedBy(other), &expected = sample::reachedBy(whole);
    REQUIRE(reached.done == expected.done);
    REQUIRE(reached.startScale == expected.startScale);
    REQUIRE(reached.scale == expected.scale);
    REQUIRE(reached.most.force == expected.most.force);
    REQUIRE(other.cells.size() == whole.cells.size());
    for (std::size_t i = 0; i < whole.cells.size(); ++i) {
      REQUIRE(verticesOf(other, i) == verticesOf(whole, i));
      REQUIRE(other.poses[i].position == whole.poses[i].position);
    }
  };
  requireSame(uninterrupted);
  for (std::size_t i = 0; i < states.size(); i += i + 1 < states.size() ? (states.size() - i) / 2 : 1) {
    iterations.push_back(states[i].engine->iterations());
    CAPTURE(iterations.back());
    writeState(folder.path() / "s.h5", problem, {"asked", {}, ""}, states[i]);
    CHECK(readStateHead(folder.path() / "s.h5").stage == softCellsStage);
    CHECK_THROWS_AS(readStateCells(folder.path() / "s.h5", {}), InputError);  // they still grow
    problem.resume = readState(folder.path() / "s.h5", problem);
    requireSame(pack(problem));
    problem.resume.reset();
  }
  return iterations;
}

TEST_CASE("a packing continues from any of its states with the same cells", "[soft]") {
  SoftLimits limits;
  SECTION("to the end") {
    const auto iterations = requireSameFromAnyState(boxAt(0.75, 6), limits);
    CHECK(iterations.front() == 4);
    CHECK(iterations.back() > 35);
  }
  SECTION("beside a wall, a rigid cell and a fixed one") {
    PackingProblem problem = problemIn(makeCylinder(Vec3(10, 0, 0), 0, 4.5, 20.0, true), 8);
    std::vector<Species>& species = problem.physics.species;
    species.resize(3, species[0]);
    species[1].count = species[2].count = 1;
    species[1].freedom.fixed = true;
    species[1].start = {Pose{1.0, Quaternion::Identity(), Vec3(10, 0, 0)}};
    requireSameFromAnyState(problem, limits, {{}, {}, {{}, true}});
  }
  SECTION("beyond the limits, in another attempt") {
    limits.force = limits.aim = 0.01;
    PackingProblem problem = boxAt(0.8, 6);
    problem.execution.limits.maxSweeps = 120;
    CHECK(requireSameFromAnyState(problem, limits).back() == 120);
  }
  SECTION("after the best of several attempts") {
    limits.usual = 0.1;  // less than can be reached
    requireSameFromAnyState(boxAt(0.75, 6), limits);
  }
  SECTION("until cells are taken out") {
    PackingProblem problem = boxAt(1.1, 6);
    problem.execution.limits.fewerCells = true;
    problem.execution.limits.maxSweeps = 100;
    CHECK(requireSameFromAnyState(problem, limits).back() == 100);
  }
}

TEST_CASE("an interrupted packing leaves its state, which belongs to its membranes", "[soft]") {
  PackingProblem problem = boxAt(0.8, 6);
  std::vector<PackingState> states;
  int polls = 0;
  problem.execution.interrupted = [&] { return ++polls > 60; };
  problem.checkpoints = Checkpoints{{}, [&](const PackingState& state) { states.push_back(state); }};
  CHECK(packSoft(problem).outcome == Outcome::interrupted);
  REQUIRE(states.size() == 1);
  CHECK(states[0].position.stage == Stage::engine);
  CHECK(states[0].engine->iterations() > 0);
  {
    const test::TemporaryFolder folder;
    PackingProblem soft = problem;
    soft.engine = sample::softEngine(problem);
    writeState(folder.path() / "s.h5", soft, {"asked", {}, ""}, states[0]);
    CHECK(readState(folder.path() / "s.h5", soft).engine->iterations() == states[0].engine->iterations());
    CHECK_THROWS_AS(readState(folder.path() / "s.h5", problem), InputError);  // undeformed cells
  }
  problem.execution.interrupted = {};
  problem.resume = states[0];
  MembraneConstants stiffer;
  stiffer.bend *= 2.0;
  CHECK_THROWS_AS(packSoft(problem, {}, {{stiffer}}), InputError);
  CHECK_THROWS_AS(packSoft(problem, {}, {{{}, true}}), InputError);
  problem.execution.limits.maxSweeps = states[0].engine->iterations();
  problem.checkpoints->savesFailed = false;
  CHECK(packSoft(problem).outcome == Outcome::outOfReach);
  CHECK(states.size() == 1);
}

TEST_CASE("cells beside a layer without cells and beside fixed ones", "[soft]") {
  const auto tube = std::shared_ptr<const Container>(makeCylinder(Vec3(10, 0, 0), 0, 5.0, 20.0, true));
  PackingProblem problem = problemIn(tube, 7);
  problem.physics.species[0].freedom.freeLayer =
      FreeLayer{std::shared_ptr<const Wall>(tube, tube->wall()), 0.8};
  Species& fixed = problem.physics.add("fixed", std::make_shared<const Shape>(sample::redCell(3)), 1);
  fixed.freedom.fixed = true;
  fixed.start = {Pose{1.0, Quaternion::Identity(), Vec3(10, 0, 0)}};
  const PackingResult packed = packSoft(problem);
  REQUIRE(packed.outcome == Outcome::certified);
  CHECK(packed.cells.size() == 8);
  for (std::size_t i = 0; i < packed.cells.size(); ++i) {
    if (packed.cells[i].species == 1) continue;
    for (const Vec3& v : verticesOf(packed, i)) {
      const Vec3 there = packed.cells[i].placement(v);
      CHECK(5.0 - std::hypot(there.y(), there.z()) > 0.8);
    }
  }
}

}  // namespace
}  // namespace packmesh
