// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/growth_relaxation.h"

#include <algorithm>

#include "packMesh/cat/growing_cells.h"
#include "packMesh/cat/step_halving.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/relaxation/schedule.h"

namespace packmesh {
namespace {

/// Number of repair rounds, and sweeps in each.
constexpr int repairRounds = 8;
constexpr std::int64_t repairSweeps = 100;

/// The cell without what relaxation has cached about its surroundings.
Body bare(const Body& body) {
  Body out = makeBody(body.id, body.species, body.shape, body.pose());
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

namespace {

/// More than sufficient for cells that fill a thousandth of the lumen.
constexpr int relaxationSweeps = 1000;

/// Halves cells that violate constraints only because of their size.
/// @return whether any were halved, on any rank
bool shrinkViolating(const Physics& physics, const Execution& execution, double smallest,
                     GrowingCells& cells) {
  std::vector<Body>& bodies = cells.all();
  const auto large = [&](const Body& body) { return body.scale > smallest; };
  std::vector<char> violates(bodies.size(), 0);
  const Certificate faults = StepHalving(physics, execution).examineOwn(cells);
  for (const MisplacedCell& cell : faults.misplaced) violates[cell.cell] = 1;
  for (const OverlappingPair& pair : faults.overlapping)
    if (large(bodies[pair.first]) && large(bodies[pair.second]))
      violates[pair.first] = violates[pair.second] = 1;
  bool any = false;
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(bodies.size()); ++i) {
    Body& body = bodies[i];
    if (!violates[i] || !cells.isOwn(i) || isFixed(physics, body) || !large(body)) continue;
    body.scale = std::max(smallest, 0.5 * body.scale);
    body.changed = any = true;
  }
  cells.updateGhosts();
  return execution.communicator.any(any);
}

}  // namespace

bool seed(const Physics& physics, const Execution& execution, double smallest,
          const std::function<bool()>& stop, std::vector<Body>& own) {
  GrowingCells cells(physics, execution, std::move(own),
                     2.0 * physics.largest(&Shape::reach) + physics.clearance, 0);
  while (shrinkViolating(physics, execution, smallest, cells)) {
    if (stop && stop()) return false;
  }
  const bool valid = StepHalving(physics, execution).examine(cells).clean() ||
                     relaxAtScale(physics, execution, smallest, relaxationSweeps, stop, cells);
  own = cells.own();
  return valid;
}

}  // namespace packmesh
