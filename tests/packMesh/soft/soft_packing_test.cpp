// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/soft_packing.h"

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
  return problem;
}

PackingProblem boxAt(double hematocrit, int cells, std::uint64_t seed = 1) {
  const double side = std::cbrt(cells * signedVolume(sample::redCell(3)) / hematocrit);
  return problemIn(makeBox(Box{Vec3::Zero(), Vec3::Constant(side)}, {true, true, true}), cells, seed);
}

/// The exact test, with the gaps required.
Certificate certificateOf(Physics physics, const SoftPacking& packed) {
  std::vector<PlacedCell> placed;
  for (const Cell& cell : packed.cells) {
    placed.push_back({cell.species, std::int32_t(physics.shapes.size()), cell.pose.placement()});
    physics.shapes.push_back(
        std::make_shared<const Shape>(cell.vertices, physics.shapes[physics.species[cell.species].shape]));
  }
  return certify(certificateInputOf(physics, placed));
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
    const SoftPacking packed = packSoft(problem, {{}}, {});
    REQUIRE(packed.outcome == Outcome::certified);
    REQUIRE(packed.cells.size() == 8);
    CHECK(packed.startScale < 0.9);
    CHECK(packed.scale == 1.0);
    const Certificate certificate = certificateOf(problem.physics, packed);
    CHECK(certificate.clean());
    CHECK(certificate.minimumGap > 0.02);
    CHECK(packed.most.force <= 10.0);
  }
}

TEST_CASE("cells fold in a tube that is too narrow for them", "[soft]") {
  PackingProblem problem = problemIn(makeCylinder(Vec3(15, 0, 0), 0, 2.75, 30.0, true), 2);
  problem.physics.wallClearance = 0.05;
  problem.execution.limits.maxSweeps = 200;
  problem.execution.limits.fewerCells = false;
  CHECK(pack(problem).outcome == Outcome::outOfReach);
  const SoftPacking packed = packSoft(problem, {{}}, {});
  REQUIRE(packed.outcome == Outcome::certified);
  const Certificate certificate = certificateOf(problem.physics, packed);
  CHECK(certificate.clean());
  CHECK(certificate.minimumWallGap > 0.05);
}

TEST_CASE("cells keep to a smoothed wall, and are not packed where their edges meet the wall itself",
          "[soft]") {
  const auto packedIn = [](double free) {
    PackingProblem problem = problemIn(std::make_shared<const SteppedTube>(2.9, free), 2);
    problem.physics.smoothWalls = true;
    SoftLimits limits;
    limits.iterations = 1500;
    return packSoft(problem, {{}}, limits);
  };
  const SoftPacking packed = packedIn(2.9);
  CHECK(packed.outcome == Outcome::certified);
  CHECK(packed.startScale < 1.0);
  CHECK_FALSE(packed.meetsWall);
  const SoftPacking outside = packedIn(2.6);  // beyond the range of the barrier
  CHECK(outside.outcome == Outcome::outOfReach);
  CHECK(outside.scale == 1.0);
  CHECK(outside.meetsWall);
  CHECK(outside.cells.empty());
}

TEST_CASE("few cells with large forces begin elsewhere, and the best attempt counts", "[soft][long]") {
  SoftLimits once, limits;
  once.usual = once.force;
  limits.usual = 0.1;
  PackingProblem problem = boxAt(0.85, 6);
  std::vector<double> first, best;
  for (int k = 0; k < 5; ++k, ++problem.physics.seed) {
    first.push_back(packSoft(problem, {{}}, once).most.force);
    const SoftPacking packed = packSoft(problem, {{}}, limits);
    CHECK(packed.outcome == Outcome::certified);
    best.push_back(packed.most.force);
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
  const SoftPacking many = packSoft(problem, {{}}, limits);
  CHECK(many.most.force == packSoft(problem, {{}}, once).most.force);
}

TEST_CASE("the pose of a deformed cell is that of the template that fits best", "[soft]") {
  const SoftPacking packed = packSoft(boxAt(0.7, 6), {{}}, {});
  REQUIRE(packed.outcome == Outcome::certified);
  const std::vector<Vec3> rest = sample::redCell(3).vertices;
  for (const Cell& cell : packed.cells) {
    double squares = 0.0;
    for (std::size_t v = 0; v < rest.size(); ++v) squares += (cell.vertices[v] - rest[v]).squaredNorm();
    CHECK(std::sqrt(squares / double(rest.size())) < 1.0);
    CHECK(cell.pose.scale == 1.0);
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
  const SoftPacking packed = packSoft(problem, {{}, {}, {{}, true}}, {});
  REQUIRE(packed.outcome == Outcome::certified);
  REQUIRE(packed.cells.size() == 7);
  Physics physics = problem.physics;
  std::vector<PlacedCell> placed = {{1, 0, pose.placement()}};
  for (const Cell& cell : packed.cells) {
    CHECK(cell.vertices.empty() == (cell.species == 2));
    placed.push_back({cell.species, 0, cell.pose.placement()});
    if (cell.vertices.empty()) continue;
    placed.back().shape = std::int32_t(physics.shapes.size());
    physics.shapes.push_back(std::make_shared<const Shape>(cell.vertices, physics.shapes[0]));
  }
  CHECK(certify(certificateInputOf(physics, placed)).clean());
}

TEST_CASE("packing soft cells ends at its limits", "[soft]") {
  SECTION("the largest force") {
    SoftLimits limits;
    limits.force = limits.aim = 0.01;
    limits.iterations = 400;
    const SoftPacking packed = packSoft(boxAt(0.8, 6), {{}}, limits);
    CHECK(packed.outcome == Outcome::outOfReach);
    CHECK(packed.cells.empty());
    CHECK(packed.most.force > 0.01);
  }
  SECTION("changes of volume and area") {
    SoftLimits limits;
    limits.iterations = 600;
    (GENERATE(true, false) ? limits.volume : limits.area) = 1e-6;
    const SoftPacking packed = packSoft(boxAt(0.8, 6), {{}}, limits);
    CHECK(packed.outcome == Outcome::outOfReach);
    CHECK(packed.scale == 1.0);
    CHECK(packed.most.force < limits.force);
    CHECK(limits.share(packed.most) > 100.0);
  }
  SECTION("a lumen in which there is no room") {
    SoftLimits limits;
    limits.iterations = 400;
    const SoftPacking packed =
        packSoft(problemIn(makeCylinder(Vec3(4, 0, 0), 0, 1.9, 8.0, true), 1), {{}}, limits);
    CHECK(packed.outcome == Outcome::outOfReach);
    CHECK(packed.cells.empty());
  }
  SECTION("on request") {
    PackingProblem problem = boxAt(0.8, 6);
    int polls = 0;
    problem.execution.interrupted = [&] { return ++polls > 60; };
    CHECK(packSoft(problem, {{}}, {}).outcome == Outcome::interrupted);
  }
}

TEST_CASE("if fewer cells suffice, those that find no room are taken out", "[soft][long]") {
  SoftLimits limits;
  limits.fewerCells = true;
  limits.iterations = 600;
  SECTION("the smallest") {
    const PackingProblem problem = boxAt(1.1, 12);
    const SoftPacking packed = packSoft(problem, {{}}, limits);
    CHECK(packed.outcome == Outcome::outOfReach);
    CHECK(packed.scale < 1.0);
    CHECK(packed.iterations == 600);
    CHECK(packed.cells.size() >= 9);
    CHECK(packed.cells.size() < 11);
    CHECK(certificateOf(problem.physics, packed).clean());
    const Membrane membrane(sample::redCell(3), {});
    for (const Cell& cell : packed.cells) CHECK(limits.allow(deformationOf(membrane, cell.vertices)));
  }
  SECTION("the most deformed") {
    limits.area = 0.02;
    const PackingProblem problem = boxAt(0.85, 12);
    const SoftPacking packed = packSoft(problem, {{}}, limits);
    CHECK(packed.scale == 1.0);
    CHECK(packed.cells.size() > 6);
    CHECK(packed.cells.size() < 12);
    CHECK(certificateOf(problem.physics, packed).clean());
  }
}

/// Packs to the end, and from states on the way again: read from files, the same cells.
/// @return iterations of the states
std::vector<std::int64_t> requireSameFromAnyState(PackingProblem problem,
                                                  const std::vector<SoftSpecies>& species,
                                                  const SoftLimits& limits) {
  std::vector<PackingState> states;
  int asked = 0;
  const SoftPacking uninterrupted = packSoft(problem, species, limits);
  problem.checkpoints = Checkpoints{[&] { return asked++ % 17 == 3; },
                                    [&](const PackingState& state) { states.push_back(state); }};
  const SoftPacking whole = packSoft(problem, species, limits);
  if (whole.end) states.push_back(*whole.end);
  problem.checkpoints.reset();
  REQUIRE(states.size() > 3);
  const test::TemporaryFolder folder;
  std::vector<std::int64_t> iterations;
  const auto requireSame = [&](const SoftPacking& other) {
    REQUIRE(other.outcome == whole.outcome);
    REQUIRE(other.iterations == whole.iterations);
    REQUIRE(other.startScale == whole.startScale);
    REQUIRE(other.scale == whole.scale);
    REQUIRE(other.most.force == whole.most.force);
    REQUIRE(other.cells.size() == whole.cells.size());
    for (std::size_t i = 0; i < whole.cells.size(); ++i) {
      REQUIRE(other.cells[i].vertices == whole.cells[i].vertices);
      REQUIRE(other.cells[i].pose.position == whole.cells[i].pose.position);
    }
  };
  requireSame(uninterrupted);
  for (std::size_t i = 0; i < states.size(); i += i + 1 < states.size() ? (states.size() - i) / 2 : 1) {
    iterations.push_back(states[i].soft->counters[0]);
    CAPTURE(iterations.back());
    writeState(folder.path() / "s.h5", problem, {"asked", {}, ""}, states[i]);
    CHECK(readStateHead(folder.path() / "s.h5").stage == softCellsStage);
    CHECK_THROWS_AS(readStateCells(folder.path() / "s.h5", {}), InputError);  // they still grow
    problem.resume = readState(folder.path() / "s.h5", problem);
    requireSame(packSoft(problem, species, limits));
    problem.resume.reset();
  }
  return iterations;
}

TEST_CASE("a packing continues from any of its states with the same cells", "[soft]") {
  SoftLimits limits;
  SECTION("to the end") {
    const auto iterations = requireSameFromAnyState(boxAt(0.75, 6), {{}}, limits);
    CHECK(iterations.front() == 4);
    CHECK(iterations.back() > 40);
  }
  SECTION("beside a wall, a rigid cell and a fixed one") {
    PackingProblem problem = problemIn(makeCylinder(Vec3(10, 0, 0), 0, 4.5, 20.0, true), 8);
    std::vector<Species>& species = problem.physics.species;
    species.resize(3, species[0]);
    species[1].count = species[2].count = 1;
    species[1].freedom.fixed = true;
    species[1].start = {Pose{1.0, Quaternion::Identity(), Vec3(10, 0, 0)}};
    requireSameFromAnyState(problem, {{}, {}, {{}, true}}, limits);
  }
  SECTION("beyond the limits, in another attempt") {
    limits.force = limits.aim = 0.01;
    limits.iterations = 120;
    CHECK(requireSameFromAnyState(boxAt(0.8, 6), {{}}, limits).back() == 120);
  }
  SECTION("after the best of several attempts") {
    limits.usual = 0.1;  // less than can be reached
    requireSameFromAnyState(boxAt(0.75, 6), {{}}, limits);
  }
  SECTION("until cells are taken out") {
    limits.fewerCells = true;
    limits.iterations = 100;
    CHECK(requireSameFromAnyState(boxAt(1.1, 6), {{}}, limits).back() == 100);
  }
}

TEST_CASE("progress tells how many iterations are left until cells have grown, and nothing while they rest",
          "[soft]") {
  PackingProblem problem = boxAt(0.75, 8);
  std::vector<Progress> told;
  problem.execution.progress = [&](const Progress& progress) {
    if (progress.stage == softCellsStage) told.push_back(progress);
  };
  const double all = double(packSoft(problem, {{}}, {}).iterations);
  REQUIRE(told.size() > 4);
  CHECK(told.front().left > 0);
  CHECK(told.back().left == 0);
  for (std::size_t i = 0; i + 1 < told.size(); ++i) {
    CAPTURE(told[i].sweep, told[i].left, all);
    if (told[i].scale < 1.0) CHECK(told[i].left > 0);
    if (told[i].left == 0) continue;
    CHECK(double(told[i].sweep + told[i].left) > 0.6 * all);
    CHECK(double(told[i].sweep + told[i].left) < 1.7 * all);
  }
}

TEST_CASE("an interrupted packing leaves its state, which belongs to its membranes", "[soft]") {
  PackingProblem problem = boxAt(0.8, 6);
  std::vector<PackingState> states;
  int polls = 0;
  problem.execution.interrupted = [&] { return ++polls > 60; };
  problem.checkpoints = Checkpoints{{}, [&](const PackingState& state) { states.push_back(state); }};
  CHECK(packSoft(problem, {{}}, {}).outcome == Outcome::interrupted);
  REQUIRE(states.size() == 1);
  CHECK(states[0].position.stage == Stage::soft);
  CHECK(states[0].soft->counters[0] > 0);
  problem.execution.interrupted = {};
  problem.resume = states[0];
  MembraneConstants stiffer;
  stiffer.bend *= 2.0;
  CHECK_THROWS_AS(packSoft(problem, {{stiffer}}, {}), InputError);
  CHECK_THROWS_AS(packSoft(problem, {{{}, true}}, {}), InputError);
  SoftLimits none;
  none.iterations = states[0].soft->counters[0];
  none.savesFailed = false;
  CHECK(packSoft(problem, {{}}, none).outcome == Outcome::outOfReach);
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
  const SoftPacking packed = packSoft(problem, {{}, {}}, {});
  REQUIRE(packed.outcome == Outcome::certified);
  CHECK(packed.cells.size() == 7);
  for (const Cell& cell : packed.cells)
    for (const Vec3& v : cell.vertices) {
      const Vec3 there = cell.pose.placement()(v);
      CHECK(5.0 - std::hypot(there.y(), there.z()) > 0.8);
    }
}

}  // namespace
}  // namespace packmesh
