// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/seeding.h"

#include <algorithm>

#include "packMesh/cat/barrier_relaxation.h"
#include "packMesh/cat/is_fixed.h"
#include "packMesh/cat/step_halving.h"
#include "packMesh/mesh/mesh_intersection.h"

namespace packmesh {
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
  GrowingCells cells(physics, execution, std::move(own), 2.0 * physics.largestReach() + physics.clearance, 0);
  while (shrinkViolating(physics, execution, smallest, cells)) {
    if (stop && stop()) return false;
  }
  const bool valid = StepHalving(physics, execution).examine(cells).clean() ||
                     relaxAtScale(physics, execution, smallest, relaxationSweeps, stop, cells);
  own = cells.own();
  return valid;
}

}  // namespace packmesh
