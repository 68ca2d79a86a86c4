// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/step_halving.h"

#include <algorithm>

#include "packMesh/cat/growing_cells.h"
#include "packMesh/certificate/certifier.h"
#include "packMesh/certificate/overlap_finder.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/parallel/blocks.h"
#include "packMesh/relaxation/schedule.h"

namespace packmesh {
namespace {

/// Smaller fractions of a step are not tried.
constexpr double shortestPart = 1.0 / 8.0;

/// Cells that a thread tests against the wall at a time.
constexpr std::int64_t halvedPerPart = 64;

bool moves(const Body& body, const GrowthStep& step) {
  return step.scale != body.scale || !step.rotation.isZero(0.0) || !step.translation.isZero(0.0);
}

}  // namespace

std::optional<std::string> StepHalving::misplacement(const Body& body, const PlacedCell& cell) const {
  const Freedom& freedom = physics_.species[cell.species].freedom;
  // Relaxation, from which cells come, tolerates centres this far outside their region.
  if (freedom.region && !freedom.fixed &&
      freedom.region->distance(body.position).distance < -tolerance::relaxationTolerance)
    return "leaves its region";
  const Wall* wall = physics_.wallOf(cell.species);
  if (!wall) return {};
  const Shape& shape = physics_.shapeOf(cell);
  const double clearance = physics_.wallClearanceOf(cell.species);
  if (wall->isAway(boundingSphere(shape.hierarchy(), cell.placement), clearance)) return {};
  WallVerdict verdict = wall->examine({shape.hierarchy(), cell.placement}, clearance);
  if (!verdict.violation && verdict.gap < clearance) return "is nearer to the wall than the clearance";
  return std::move(verdict.violation);
}

Certificate StepHalving::examineOwn(const GrowingCells& cells) const {
  std::vector<PlacedCell> placedCells;
  std::vector<std::int64_t> own;
  Certificate faults;
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(cells.all().size()); ++i) {
    placedCells.push_back(placed(cells.all()[i]));
    if (!cells.isOwn(i)) continue;
    own.push_back(i);
    if (auto reason = misplacement(cells.all()[i], placedCells.back()))
      faults.misplaced.push_back({i, std::move(*reason)});
  }
  faults.overlapping = findOverlaps(certificateInputOf(physics_, placedCells, execution_.threads), own);
  faults.cells = static_cast<std::int64_t>(own.size());
  return faults;
}

Certificate StepHalving::examine(const GrowingCells& cells) const {
  Certificate faults = examineOwn(cells);
  const auto ofOthers = [&](const OverlappingPair& pair) { return !cells.isOwn(pair.first); };
  faults.overlapping.erase(std::remove_if(faults.overlapping.begin(), faults.overlapping.end(), ofOthers),
                           faults.overlapping.end());
  std::vector<std::int64_t> ids;
  for (const Body& body : cells.all()) ids.push_back(body.id);
  return ofAllRanks(faults, ids, execution_.communicator);
}

Certificate StepHalving::examine(const std::vector<Body>& cells,
                                 const std::vector<std::int64_t>& which) const {
  std::vector<PlacedCell> placedCells;
  for (const Body& body : cells) placedCells.push_back(placed(body));
  Certificate faults;
  faults.overlapping = findOverlaps(certificateInputOf(physics_, placedCells, execution_.threads), which);
  for (const std::int64_t i : which)
    if (auto reason = misplacement(cells[i], placedCells[i])) faults.misplaced.push_back({i, *reason});
  return faults;
}

void StepHalving::take(const std::vector<GrowthStep>& steps, const CellSurroundings& surroundings,
                       GrowingCells& cells, StepHalvingSums& sums) const {
  std::vector<Body>& bodies = cells.all();
  const Box bounds = physics_.container->bounds();
  const Vec3 period = physics_.container->period();
  std::vector<Pose> before(bodies.size());
  std::vector<Vec3> listed(bodies.size());    // positions before the steps
  std::vector<char> tried(bodies.size(), 0);  // own cells that have a step to take
  const auto place = [&](std::int64_t i) {
    Body& body = bodies[i];
    const std::optional<AxisCone>& cone = physics_.species[body.species].freedom.cone;
    Pose pose = stepped(before[i], steps[i], body.stepTaken, cone ? &*cone : nullptr);
    if (body.stepTaken > 0.0) pose.position = wrapped(pose.position, bounds, period);
    body.setPose(pose);
    body.changed = body.touched = true;
  };
  const auto forAll = [&](const auto& work) {
    execution_.threads.forEachPart(static_cast<std::int64_t>(bodies.size()),
                                   [&](std::int64_t begin, std::int64_t end, int) {
                                     for (std::int64_t i = begin; i < end; ++i) work(i);
                                   });
  };
  forAll([&](std::int64_t i) {
    Body& body = bodies[i];
    listed[i] = body.position;
    body.touched = false;
    if (!cells.isOwn(i)) return;
    body.stepTaken = 1.0;
    if (isFixed(physics_, body) || !moves(body, steps[i])) return;
    before[i] = body.pose();
    tried[i] = 1;
    place(i);
  });
  sums.steps += std::count(tried.begin(), tried.end(), 1);

  std::vector<PlacedCell> placedCells(bodies.size());
  CertificateInput input = certificateInputOf(physics_, placedCells, execution_.threads);
  input.own = &cells.ownFlags();
  const OverlapFinder overlaps(input, surroundings.neighbors(), std::move(listed));
  std::vector<std::int64_t> changed;
  for (bool first = true;; first = false) {
    cells.updateGhosts();
    changed.clear();
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(bodies.size()); ++i)
      if (bodies[i].touched) changed.push_back(i);
    forAll([&](std::int64_t i) {
      if (first || bodies[i].touched) placedCells[i] = placed(bodies[i]);
      bodies[i].touched = false;
    });
    std::vector<char> offends(bodies.size(), 0);
    for (const OverlappingPair& pair : overlaps(changed)) {
      offends[pair.first] = offends[pair.second] = 1;
      sums.violatingPairs += first && cells.isOwn(pair.first);
    }
    std::vector<char> misplaced(changed.size(), 0);
    execution_.threads.forEachPart(
        static_cast<std::int64_t>(changed.size()),
        [&](std::int64_t begin, std::int64_t end, int) {
          for (std::int64_t k = begin; k < end; ++k) {
            const std::int64_t i = changed[k];
            misplaced[k] = cells.isOwn(i) && misplacement(bodies[i], placedCells[i]);
          }
        },
        halvedPerPart);
    for (std::size_t k = 0; k < changed.size(); ++k) {
      if (!misplaced[k]) continue;
      offends[changed[k]] = 1;
      sums.misplaced += first;
    }
    bool any = false;
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(bodies.size()); ++i) {
      Body& body = bodies[i];
      if (!offends[i] || !tried[i] || body.stepTaken == 0.0) continue;
      body.stepTaken = body.stepTaken > shortestPart ? 0.5 * body.stepTaken : 0.0;
      sums.stayed += body.stepTaken == 0.0;
      place(i);
      any = true;
    }
    if (!execution_.communicator.any(any)) return;
  }
}

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
    if (!relaxDeepContacts(relaxation, repairSweeps, limits)) break;
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
