// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/barrier_relaxation.h"

#include "packMesh/core/tolerances.h"
#include "packMesh/relaxation/body_state.h"
#include "packMesh/relaxation/relaxation.h"
#include "packMesh/relaxation/schedule.h"

namespace packmesh {
namespace {

/// Rounds of repair, and sweeps in each.
constexpr int repairRounds = 8;
constexpr std::int64_t repairSweeps = 100;

RelaxationInput inputOf(const GrowthScene& scene) {
  RelaxationInput input;
  input.shapes = scene.shapes;
  input.walls = scene.walls;
  input.bounds = scene.container->bounds();
  input.period = scene.container->period();
  input.clearance = scene.clearance + tolerance::relaxationMargin;
  input.wallClearance = scene.wallClearance + tolerance::relaxationMargin;
  input.rotate = scene.rotate;
  return input;
}

/// All cells, on every rank.
GrowthState cellsOf(const Relaxation& relaxation, GrowthState state, const Communicator& communicator) {
  std::vector<BodyState> own;
  for (const Body& body : relaxation.cells()) own.push_back(stateOf(body));
  for (const BodyState& cell : communicator.gatherAll(own)) state[cell.id].pose = bodyOf(cell).pose();
  return state;
}

}  // namespace

bool relaxAtScale(const GrowthScene& scene, double scale, int sweeps, const std::function<bool()>& stop,
                  StepHalving& judge, GrowthState& state) {
  const CellShares shares = scene.sharesOf(state);
  std::vector<Body> bodies;
  for (std::size_t i = 0; i < state.size(); ++i) {
    if (!shares.own(static_cast<std::int64_t>(i))) continue;
    const GrowingCell& cell = state[i];
    Body body;
    body.id = static_cast<std::int64_t>(i);
    body.species = cell.species;
    body.scale = scale;
    body.position = cell.pose.position;
    body.orientation = cell.pose.orientation;
    body.rotation = body.orientation.toRotationMatrix();
    bodies.push_back(body);
  }
  Relaxation relaxation(inputOf(scene), std::move(bodies), scene.communicator);
  ScheduleLimits limits;
  limits.stop = stop;
  limits.maxSweeps = sweeps;
  if (!relax(relaxation, tolerance::relaxationTolerance, limits)) return false;
  for (int round = 0; round < repairRounds; ++round) {
    const GrowthState relaxed = cellsOf(relaxation, state, scene.communicator);
    const Certificate faults = judge.examine(relaxed);
    if (faults.clean()) {
      state = relaxed;
      return true;
    }
    for (const OverlappingPair& pair : faults.overlapping)
      relaxation.demandClearance(pair.first, pair.second, tolerance::repairClearance);
    for (const MisplacedCell& cell : faults.misplaced)
      relaxation.demandWallClearance(cell.cell, tolerance::repairClearance);
    limits.maxSweeps = relaxation.sweeps() + repairSweeps;
    if (!settle(relaxation, tolerance::relaxationTolerance, repairSweeps, limits)) return false;
  }
  return false;
}

}  // namespace packmesh
