// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/barrier_relaxation.h"

#include <algorithm>

#include "packMesh/core/tolerances.h"
#include "packMesh/growth/step_halving.h"
#include "packMesh/relaxation/schedule.h"

namespace packmesh {
namespace {

/// Number of repair rounds, and sweeps in each.
constexpr int repairRounds = 8;
constexpr std::int64_t repairSweeps = 100;

/// The cell without what relaxation has cached about its surroundings.
Body bare(const Body& body) {
  Body out = makeBody(body.id, body.species, body.pose());
  out.stepTaken = body.stepTaken;
  return out;
}

std::vector<Body> bare(std::vector<Body> bodies) {
  for (Body& body : bodies) body = bare(body);
  return bodies;
}

}  // namespace

RelaxationInput relaxationInputOf(const GrowthScene& scene) {
  RelaxationInput input;
  input.shapes = scene.shapes;
  input.walls = scene.walls;
  input.freedoms = scene.freedoms;
  input.bounds = scene.container->bounds();
  input.period = scene.container->period();
  input.clearance = scene.clearance + tolerance::relaxationMargin;
  input.wallClearance = scene.wallClearance + tolerance::relaxationMargin;
  input.rotate = scene.rotate;
  input.threads = scene.threads;
  return input;
}

bool relaxAtScale(const GrowthScene& scene, double scale, int sweeps, const std::function<bool()>& stop,
                  GrowingCells& cells) {
  std::vector<Body> bodies = bare(cells.own());
  for (Body& body : bodies)
    if (!scene.isFixed(body)) body.scale = std::max(body.scale, scale);
  Relaxation relaxation(relaxationInputOf(scene), std::move(bodies), scene.communicator);
  ScheduleLimits limits;
  limits.stop = stop;
  limits.maxSweeps = sweeps;
  if (!relax(relaxation, tolerance::relaxationTolerance, limits)) return false;
  const std::vector<Body> before = cells.own();
  for (int round = 0; round < repairRounds; ++round) {
    cells.replace(bare(relaxation.cells()));
    const Certificate faults = StepHalving(scene).examine(cells);
    if (faults.clean()) return true;
    for (const OverlappingPair& pair : faults.overlapping)
      relaxation.demandClearance(pair.first, pair.second, tolerance::repairClearance);
    for (const MisplacedCell& cell : faults.misplaced)
      relaxation.demandWallClearance(cell.cell, tolerance::repairClearance);
    limits.maxSweeps = relaxation.sweeps() + repairSweeps;
    if (!settle(relaxation, tolerance::relaxationTolerance, repairSweeps, limits)) break;
  }
  cells.replace(before);
  return false;
}

}  // namespace packmesh
