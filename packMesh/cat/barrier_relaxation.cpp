// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/barrier_relaxation.h"

#include <algorithm>

#include "packMesh/core/tolerances.h"
#include "packMesh/cat/is_fixed.h"
#include "packMesh/cat/step_halving.h"
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

bool relaxAtScale(const Physics& physics, const Execution& execution, double scale, int sweeps,
                  const std::function<bool()>& stop, GrowingCells& cells) {
  std::vector<Body> bodies = bare(cells.own());
  for (Body& body : bodies)
    if (!isFixed(physics, body)) body.scale = std::max(body.scale, scale);
  Relaxation relaxation(physics, execution, std::move(bodies));
  ScheduleLimits limits;
  limits.stop = stop;
  limits.maxSweeps = sweeps;
  if (!relax(relaxation, limits)) return false;
  const std::vector<Body> before = cells.own();
  for (int round = 0; round < repairRounds; ++round) {
    cells.replace(bare(relaxation.cells()));
    const Certificate faults = StepHalving(physics, execution).examine(cells);
    if (faults.clean()) return true;
    for (const OverlappingPair& pair : faults.overlapping)
      relaxation.demandClearance(pair.first, pair.second, tolerance::repairClearance);
    for (const MisplacedCell& cell : faults.misplaced)
      relaxation.demandWallClearance(cell.cell, tolerance::repairClearance);
    limits.maxSweeps = relaxation.sweeps() + repairSweeps;
    if (!settle(relaxation, repairSweeps, limits)) break;
  }
  cells.replace(before);
  return false;
}

}  // namespace packmesh
