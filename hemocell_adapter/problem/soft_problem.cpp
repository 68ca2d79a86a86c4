// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/soft_problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/problem/make_species.h"
#include "hemocell_adapter/problem/parts.h"

namespace packmesh::hemocell {
namespace {

/// HemoCell deletes cells with a vertex on a solid node: a vertex this far from the wall is on none [dx].
const double wallClearanceOfSoft = std::sqrt(0.5);
/// Iterations with that room, and its share of the time that is left; in capillaries that leave no room for
/// it, cells may be nearer to the wall. A tenth of the time is for the certificate.
constexpr std::int64_t iterationsWithRoom = 4000;
constexpr double shareWithRoom = 0.5, shareOfTimeForSoft = 0.9;

std::vector<SoftSpecies> softSpecies(const Problem& problem, const PartsToPack& packed) {
  std::vector<SoftSpecies> soft;
  for (const Part& part : packed.parts) {
    const CellSpecies& species = problem.species[part.species];
    soft.push_back({membraneOf(problem, species), species.rigid});
  }
  return soft;
}

/// With room at the wall, if there can be more than is demanded, and with as much as is demanded.
/// @param ofNodes the lumen consists of fluid nodes: room is what a smooth wall leaves
std::vector<Clearances> softLevels(const Problem& problem, bool ofNodes) {
  std::vector<Clearances> levels = {problem.demanded};
  const bool mayHaveRoom = ofNodes ? problem.demanded.wall == 0.0 : problem.request.choosesWallClearance();
  if (!problem.lumen.solidWalls || !problem.lumen.container->wall() || !mayHaveRoom) return levels;
  levels.insert(levels.begin(), problem.demanded);
  if (!ofNodes)
    levels.front().wall = std::max(problem.demanded.wall, wallClearanceOfSoft * problem.request.dx);
  return levels;
}

/// The species with these cells, which are all there; fixed ones stay.
std::vector<SpeciesPlan> softPlans(const Problem& problem, const PartsToPack& packed,
                                   const std::vector<Cell>& cells) {
  std::vector<SpeciesPlan> plans(problem.species.begin(), problem.species.end());
  for (std::size_t s = 0; s < plans.size(); ++s) {
    SpeciesPlan& species = plans[s];
    species.start.clear();
    for (PresentCell& cell : species.fixed) {
      if (cell.shape < 0) continue;
      cell.vertices = problem.shapes[cell.shape]->mesh().vertices;
      cell.shape = -1;
    }
    species.ownTriangles = problem.species[s].shape->mesh().triangles;
    species.blood = {};
    species.startFrom = "packing soft cells";
    species.stock = 0;
  }
  for (const Cell& cell : cells) {
    std::vector<PresentCell>& start = plans[packed.parts[cell.species].species].start;
    // The angles of a line stand for a rotation up to rounding, which the vertices make up for.
    const PosLine line = posLineOf(cell.pose);
    const Mat3 turned = placementOf(line).linear.transpose() * cell.pose.orientation.toRotationMatrix();
    start.emplace_back(line);
    for (const Vec3& v : cell.vertices) start.back().vertices.push_back(turned * v);
  }
  return plans;
}

/// Deviations that packing undeformed cells tolerates, and that are not worth telling [µm; rad].
constexpr double littleOutside = 0.01, littleTurned = 1e-3;

/// Cells that were kept in regions and to directions before they grew, and are not any more.
std::optional<std::string> strayWarning(const Problem& problem, const PartsToPack& packed,
                                        const std::vector<Cell>& cells) {
  std::int64_t outside = 0, turned = 0;
  for (const Cell& cell : cells) {
    const Freedom& freedom = packed.parts[cell.species].cells.freedom;
    if (freedom.region && freedom.region->distance(cell.pose.position).distance < -littleOutside) ++outside;
    if (freedom.cone && freedom.cone->angle(cell.pose.orientation) > freedom.cone->spread + littleTurned)
      ++turned;
  }
  std::string text;
  if (outside > 0)
    text = fmt::format("{} of {} cells have their centres outside of their {}", outside, cells.size(),
                       problem.layout.profile ? "layers of the profile" : "regions");
  if (turned > 0)
    text += fmt::format("{}{} of {} cells are turned beyond their spread", text.empty() ? "" : ", ", turned,
                        cells.size());
  if (text.empty()) return {};
  return text + ": soft cells are kept to these only until they grow";
}

std::string failureOf(const SoftPacking& packed, const SoftLimits& limits) {
  const std::string after = fmt::format(" after {} iterations", packed.iterations);
  if (packed.scale == 0.0) return "the small undeformed cells from which soft ones grow could not be packed";
  if (packed.scale < 1.0)
    return fmt::format("the cells had grown to {:.2f} of their size", packed.scale) + after;
  if (packed.meetsWall) return "edges of a membrane met the steps of the wall" + after;
  if (!(packed.most.force <= limits.force))
    return fmt::format("the largest force on a vertex was {:.2f} pN", packed.most.force) + after +
           fmt::format(", and {:.6g} pN are allowed ({})", limits.force, named("max-force"));
  if (limits.allow(packed.most)) return "the cells have their full size, but had not come to rest" + after;
  const bool ofVolume = !(std::abs(packed.most.volume) <= limits.volume);
  return fmt::format("the {} of a cell changed by {:.2f} %", ofVolume ? "volume" : "area",
                     100.0 * (ofVolume ? packed.most.volume : packed.most.area)) +
         after +
         fmt::format(", and {:.6g} % are allowed ({})", 100.0 * (ofVolume ? limits.volume : limits.area),
                     named(ofVolume ? "max-volume-change" : "max-area-change"));
}

}  // namespace

SoftProblem packSoftProblem(const Problem& problem, const SoftRun& run) {
  const Wall* const wall = problem.lumen.container->wall();
  const bool ofNodes = wall && wall->smoothReach() > 0.0;
  const std::vector<Clearances> levels = softLevels(problem, ofNodes);
  SoftProblem made;
  std::string withRoom;  // why not; empty if it was not tried, as in a run that is continued
  for (std::size_t n = 0; n < levels.size(); ++n) {
    const bool last = n + 1 == levels.size();
    const PartsToPack packed = partsAt(problem, problem.layout, levels[n]);
    const auto packing =
        std::make_shared<PackingProblem>(packingProblemOf(problem, packed, run.interrupted, run.progress));
    packing->physics.smoothWalls = ofNodes && !last;
    made.packing = packing;
    if (!run.prepare(*packing, last)) continue;
    if (const double most = problem.request.maxSeconds; most > 0.0)
      packing->execution.limits.maxSeconds = std::max(
          Limits::leastSeconds, (last ? shareOfTimeForSoft : shareWithRoom) * (most - run.elapsed()));
    SoftLimits limits;
    limits.force = problem.request.maxForce;
    limits.volume = problem.request.maxVolumeChange;
    limits.area = problem.request.maxAreaChange;
    limits.aim = std::min(limits.aim, 0.9 * limits.force);
    if (!last) limits.iterations = iterationsWithRoom;
    limits.fewerCells = last && problem.request.bestEffort;
    limits.savesFailed = last;
    limits.deform = run.deform;
    if (problem.request.maxIterations)
      limits.iterations = std::min(limits.iterations, *problem.request.maxIterations);
    SoftPacking soft = packSoft(*packing, softSpecies(problem, packed), limits);
    if (soft.outcome == Outcome::interrupted) return made;
    if (soft.outcome != Outcome::certified) {
      made.failure = failureOf(soft, limits);
      if (!last) withRoom = made.failure;
      made.fewer = !soft.cells.empty();
      if (!made.fewer) continue;
    } else if (soft.startScale == 1.0) {
      made.packing.reset();
      made.problem = problem;
      return made;
    }
    if (last && levels.size() > 1 && !ofNodes)
      made.notices.warnings.push_back(
          fmt::format("vertices are nearer to the wall than {:.4g} µm (0.71 dx), at which none is on a solid "
                      "node: HemoCell deletes cells with a vertex on one, and a smaller dx leaves them more "
                      "room{}",
                      levels.front().wall, withRoom.empty() ? "" : "; that far from the wall " + withRoom));
    if (auto warning = strayWarning(problem, packed, soft.cells))
      made.notices.warnings.push_back(std::move(*warning));
    made.end = std::move(soft.end);
    made.problem = withOtherCells(problem, softPlans(problem, packed, soft.cells), levels[n]);
    return made;
  }
  return made;
}

}  // namespace packmesh::hemocell
