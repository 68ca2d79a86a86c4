// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/packing_attempts.h"

#include <fmt/format.h>

#include <algorithm>

#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/output/growth_frames.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/build_scene.h"
#include "packMesh/core/error.h"
#include "packMesh/packing/pack.h"
#include "packMesh/packing/problem_digest.h"
#include "packMesh/packing/state_file.h"
#include "packMesh/packing/validate_problem.h"

namespace packmesh::hemocell {
namespace {

/// Ranks on other nodes may find different files under the same names.
void requireSameOnAllRanks(const PackingProblem& problem) {
  const Communicator& ranks = problem.communicator;
  if (ranks.alone()) return;
  const std::string own = digestOf(problem), first = ranks.broadcast(own, 0);
  together(ranks, [&] {
    if (own != first)
      throw InputError(
          fmt::format("rank {} has a different problem than rank 0 (lumen, cells, counts, clearances "
                      "or seed): do all nodes see the same files?",
                      ranks.rank()));
  });
}

/// False if the clearances alone make it impossible: lumen too small, fixed cells closer to each other. The
/// same on all ranks.
bool isPossible(const PackingProblem& problem) {
  try {
    validate(problem);
  } catch (const InputError&) {
    return false;
  }
  return true;
}

/// Prints statistics of packing, in detail.
void tellEffort(const Statistics& statistics, const Communicator& ranks) {
  for (const std::string& line : effortLines(statistics)) log::detail(line);
  if (!ranks.alone()) {
    const double each = 1.0 / double(std::max<std::int64_t>(1, statistics.effort()));
    log::detail(fmt::format(
        "Rank 0 sent {:.1f} messages and {:.1f} kB per {}", each * double(ranks.traffic().messages),
        1e-3 * each * double(ranks.traffic().bytes), statistics.growth ? "iteration" : "sweep"));
  }
  if (!statistics.growth && statistics.blocks < ranks.size())
    log::info(fmt::format("Note: {} block{} of cells for {} ranks: the remaining ranks were idle",
                          statistics.blocks, statistics.blocks == 1 ? "" : "s", ranks.size()));
}

/// Warns of cells at the wall, which are soon lost.
void warnOfNoRoom(const std::vector<Clearances>& levels, const RoomyPacking& packing, const Scene& scene) {
  const bool room = levels.size() == 1 || packing.clearances.wall > levels.back().wall ||
                    packing.clearances.membranes > levels.back().membranes;
  if (room || packing.result.outcome != Outcome::certified || !scene.lumen.solidWalls ||
      !scene.lumen.container->wall())
    return;
  log::warning(fmt::format(
      "at this hematocrit no gap between the cells and the wall could be kept ({:.6g} µm were tried): "
      "HemoCell silently deletes a cell as soon as it moves onto a wall node. Fewer cells are lost at a "
      "lower hematocrit",
      levels.front().wall));
}

}  // namespace

PackingAttempts::PackingAttempts(Scene& scene, const Communicator& ranks, const RunHooks& hooks)
    : scene_(scene), ranks_(ranks), progress_(scene, ranks.size()), hooks_(hooks) {
  if (!hooks_.interrupted) hooks_.interrupted = interrupted;
  if (!hooks_.progress) hooks_.progress = [this](const Progress& p) { progress_(p); };
}

PackingProblem PackingAttempts::problemWith(const Clearances& clearances) {
  setClearances(scene_, clearances);
  return problemOf(scene_, hooks_.interrupted, hooks_.progress);
}

std::optional<PackingResult> PackingAttempts::operator()(const Clearances& clearances,
                                                         const AttemptLimits& limits) {
  PackingProblem problem = problemWith(clearances);
  if (!begun_) requireSameOnAllRanks(problem);
  if (!limits.fewerCells && !isPossible(problem)) return {};
  problem.limits.maxSeconds = limits.maxSeconds;
  if (limits.maxSweeps > 0) problem.limits.maxSweeps = std::min(limits.maxSweeps, problem.limits.maxSweeps);
  problem.limits.sweepsForFew = limits.sweepsForFew;
  problem.limits.fewerCells = limits.fewerCells;
  std::optional<GrowthFrames> frames;
  if (scene_.growthFrames > 0) {
    frames.emplace(problem, scene_.outputDirectory / "growth_frames", scene_.growthFrames);
    problem.observe = [&frames](const std::vector<PlacedCell>& own) { frames->add(own); };
  }
  StateFiles states(scene_, problem);
  if (scene_.stateFile) problem.checkpoints = states.checkpoints();
  if (scene_.restart && !begun_) problem.resume = stateToContinue(scene_, problem);
  begun_ = true;
  PackingResult result = pack(problem);
  saved_ = states.saved().value_or(saved_);  // an attempt that saved nothing leaves the state of the last one
  if (result.outcome == Outcome::outOfReach && !limits.fewerCells)
    log::detail(fmt::format(
        "Clearances of {:.6g} µm between membranes and {:.6g} µm to the wall: no packing in {} {}",
        clearances.membranes, clearances.wall, result.statistics.effort(), result.statistics.unit()));
  return result;
}

RoomyPacking PackingAttempts::withRoom(const Timer& timer) {
  const std::vector<Clearances> levels = clearanceLevels(scene_);
  RoomyPacking packing = packWithRoom(
      scene_, levels, firstLevel(levels), scene_.mostCells(), [&] { return ranks_.max(timer.wall()); },
      [&](const Clearances& clearances, const AttemptLimits& limits) { return (*this)(clearances, limits); });
  if (packing.result.outcome == Outcome::interrupted || ranks_.any(hooks_.interrupted())) return packing;
  if (scene_.largestClearance) setClearances(scene_, packing.clearances);  // the last attempt may have failed
  tellEffort(packing.result.statistics, ranks_);
  warnOfNoRoom(levels, packing, scene_);
  return packing;
}

std::size_t PackingAttempts::firstLevel(const std::vector<Clearances>& levels) {
  if (!scene_.restart || levels.size() == 1) return 0;
  std::string digest;
  together(ranks_, [&] { digest = readStateHead(*scene_.restart).digest; });
  std::size_t level = 0;
  while (level + 1 < levels.size() && digestOf(problemWith(levels[level])) != digest) ++level;
  return level;
}

}  // namespace packmesh::hemocell
