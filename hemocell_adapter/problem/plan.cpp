// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace packmesh::hemocell {
namespace {

/// Default target of the clearances, in lattice spacings.
constexpr double wallClearanceOfRigid = 1.0, membraneRoom = 0.1;

/// Fractions of it that are tried.
constexpr double shares[] = {1.0, 0.5, 0.25, 0.0};

/// Limits of an attempt with more clearance than demanded: this many sweeps times cells, but at least the
/// smallest and at most the largest number of sweeps. HemoCell's pipe keeps the full clearance in 60 sweeps
/// at 0.45 and in 155 at 0.48, half of it in 104 at 0.50; a narrow inlet with 76 cells at 0.30 takes 544,
/// half a second. If only few contacts are left then, as in large packings, the attempt goes on to the
/// largest.
constexpr std::int64_t cheapCellSweeps = 160000, leastSweeps = 160, mostSweeps = 600;

/// The same for an engine [iterations]: in boxes and tubes it succeeded within 18 to 62, or not at all.
constexpr std::int64_t cheapIterations = 100;

/// Sweeps, or iterations of an engine, of an attempt in the search for the largest clearance, if the job has
/// no limit. With 14,000 the clearance is 7 to 33 % larger, and the search takes ten times as long.
constexpr std::int64_t thoroughSweeps = 600;

/// That search ends when the step is this fraction of the clearance, or this length [µm].
constexpr double finestShare = 0.02, finestStep = 0.001;

/// Fraction of the remaining time that an attempt with more clearance than demanded may take.
constexpr double shareOfTimeForClearance = 0.25;

/// Where soft cells may be needed, undeformed ones get this share of the time limit, and so many sweeps.
constexpr double shareOfUndeformed = 0.5;
constexpr std::int64_t sweepsOfUndeformed = 10000;

/// HemoCell deletes cells with a vertex on a solid node: a vertex this far from the wall is on none [dx].
const double wallClearanceOfSoft = std::sqrt(0.5);
/// Iterations of soft cells with that room, and its share of the time that is left; in capillaries that leave
/// no room for it, cells may be nearer to the wall. Iterations without, if the request says nothing.
constexpr std::int64_t iterationsWithRoom = 4000, iterationsOfSoft = 20000;
constexpr double shareWithRoom = 0.5;

/// Whether an existing packing is only to be certified again: it is kept unchanged.
bool givenWhole(const Problem& problem) {
  for (const CellSpecies& species : problem.species)  // profiles give initial poses to all others
    if (std::int64_t(species.fixed.size() + species.start.size()) < species.count) return false;
  return std::all_of(problem.atDemanded.parts.begin(), problem.atDemanded.parts.end(),
                     [](const Part& part) { return part.cells.placed() >= part.cells.count; });
}

}  // namespace

bool triesMoreClearance(const Request& request) {
  return !request.packCellsConventions && !request.cat.usesReserve() &&
         (request.choosesClearance() || request.choosesWallClearance() || request.largestClearance);
}

double leastWallRoom(const Request& request) {
  return *std::prev(std::end(shares), 2) * wallClearanceOfRigid * request.dx;
}

std::vector<Clearances> clearanceLevels(const Problem& problem) {
  const Clearances demanded = problem.demanded;
  if (!triesMoreClearance(problem.request) || givenWhole(problem)) return {demanded};
  const bool membranes = problem.request.choosesClearance() || problem.request.largestClearance;
  // Faces through which blood flows: the same gap to the cells beyond them.
  const double toWall = problem.lumen.solidWalls ? wallClearanceOfRigid : 0.5 * membraneRoom;
  const bool wall = problem.request.choosesWallClearance() && problem.lumen.container->wall();
  std::vector<Clearances> levels;
  for (const double share : shares) {
    Clearances level = demanded;
    if (membranes) level.membranes = std::max(demanded.membranes, share * membraneRoom * problem.request.dx);
    if (wall) level.wall = std::max(demanded.wall, share * toWall * problem.request.dx);
    levels.push_back(level);
    if (!membranes && !wall) break;
  }
  return levels;
}

namespace {

bool isSmoothed(const Problem& problem) {
  const Wall* const wall = problem.lumen.container->wall();
  return wall && wall->smoothReach() > 0.0;
}

std::int64_t atMost(std::int64_t number, const std::optional<std::int64_t>& ofRequest) {
  return ofRequest ? std::min(number, *ofRequest) : number;
}

/// Undeformed cells with all their clearances.
std::vector<Rung> undeformedRungs(const Problem& problem) {
  const Request& request = problem.request;
  const bool grow = request.method == Method::cat;
  const std::int64_t cheapSweeps =
      grow ? cheapIterations
           : std::clamp(cheapCellSweeps / std::max<std::int64_t>(1, problem.mostCells()), leastSweeps,
                        mostSweeps);
  const std::vector<Clearances> levels = clearanceLevels(problem);
  const bool chosen = levels.back().membranes == 0.0 && levels.back().wall == 0.0;  // none is asked for
  std::vector<Rung> rungs;
  for (const Clearances& level : levels) {
    Rung& rung = rungs.emplace_back();
    rung.clearances = level;
    if (rungs.size() == levels.size()) break;
    rung.most = atMost(cheapSweeps, request.maxIterations);
    rung.sweepsForFew = grow ? 0 : mostSweeps - cheapSweeps;
    rung.share = shareOfTimeForClearance;
    rung.someCloser = chosen;
  }
  return rungs;
}

/// The same with less effort, where other rungs follow or have failed.
std::vector<Rung> undeformedBesideSoft(const Problem& problem) {
  std::vector<Rung> rungs = undeformedRungs(problem);
  for (Rung& rung : rungs) {
    rung.savesStates = false;
    if (rung.most == 0) rung.most = atMost(sweepsOfUndeformed, problem.request.maxIterations);
  }
  return rungs;
}

/// With room at the wall, if there can be more than is demanded, and with as much as is demanded.
std::vector<Rung> softRungs(const Problem& problem) {
  const Request& request = problem.request;
  const bool ofNodes = isSmoothed(problem);
  const bool mayHaveRoom = ofNodes ? problem.demanded.wall == 0.0 : request.choosesWallClearance();
  Rung last;
  last.cells = Rung::Cells::soft;
  last.clearances = problem.demanded;
  last.most = request.maxIterations.value_or(iterationsOfSoft);
  last.fewerCells = request.bestEffort;
  if (!problem.lumen.solidWalls || !problem.lumen.container->wall() || !mayHaveRoom) return {last};
  Rung withRoom = last;
  if (ofNodes) {
    withRoom.smoothWalls = true;  // room is what the smooth wall of nodes leaves
  } else {
    withRoom.clearances.wall = std::max(problem.demanded.wall, wallClearanceOfSoft * request.dx);
    last.lessRoomThan = withRoom.clearances.wall;
  }
  withRoom.share = shareWithRoom;
  withRoom.most = atMost(iterationsWithRoom, request.maxIterations);
  withRoom.fewerCells = withRoom.savesFailed = false;
  return {withRoom, last};
}

/// Whether any of its cells may deform.
bool maySoften(const Problem& problem) {
  return problem.request.deforms() &&
         std::any_of(problem.species.begin(), problem.species.end(), [](const CellSpecies& species) {
           return !species.rigid && species.mostCells() > std::int64_t(species.fixed.size());
         });
}

void append(std::vector<Rung>& rungs, const std::vector<Rung>& more) {
  rungs.insert(rungs.end(), more.begin(), more.end());
}

}  // namespace

std::string Rung::text(bool limited) const {
  std::string text = isSoft() ? "soft cells" : "undeformed cells";
  if (cells == Cells::probe) return text + ": whether they can be packed easily";
  if (clearances.membranes > 0.0) text += fmt::format(", {:.4g} µm between membranes", clearances.membranes);
  if (clearances.wall > 0.0) text += fmt::format(", {:.4g} µm to the wall", clearances.wall);
  if (smoothWalls) text += ", off the steps of the wall";
  if (most > 0) text += fmt::format(", at most {} {}", most, isSoft() ? "iterations" : "sweeps");
  if (limited && until * share < 1.0)
    text += fmt::format(
        ", {:.0f} % of the time{}", 100.0 * share,
        until < 1.0 ? fmt::format(" until {:.0f} % of the limit", 100.0 * until) : " that is left");
  if (fewerCells) text += "; fewer of them if need be";
  return text;
}

std::vector<std::string> Plan::lines(bool limited) const {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < rungs.size(); ++i) {
    lines.push_back(fmt::format("{}. {}", i + 1, rungs[i].text(limited)));
    if (rungs[i].otherwise != i + 1) lines.back() += fmt::format("; otherwise {}", rungs[i].otherwise + 1);
  }
  if (widens) lines.emplace_back("afterwards: larger clearances between membranes");
  return lines;
}

Plan planOf(const Problem& problem, LumenSample& sample, Begin begin) {
  const Request& request = problem.request;
  Plan plan;
  plan.widens = request.largestClearance;
  std::vector<Rung>& rungs = plan.rungs;
  const bool soft = maySoften(problem);
  const bool asIfNeeded = soft && request.deforming == Deforming::asLast && begin == Begin::anew &&
                          forecastOf(problem, sample).effectiveFraction <= Forecast::possible;
  const std::vector<Rung> softOnes = soft ? softRungs(problem) : std::vector<Rung>{};
  if (asIfNeeded) {
    rungs = undeformedBesideSoft(problem);
    for (Rung& rung : rungs) rung.until = shareOfUndeformed;
  } else if (begin != Begin::soft) {
    if (soft && begin == Begin::anew) {
      rungs = {softOnes.front()};
      rungs.front().cells = Rung::Cells::probe;
      rungs.front().fewerCells = false;
    }
    append(rungs, undeformedRungs(problem));
  }
  const std::size_t firstSoft = rungs.size();
  append(rungs, softOnes);
  if (soft && request.bestEffort) append(rungs, undeformedBesideSoft(problem));
  if (!soft || request.bestEffort) rungs.back().fewerCells = true;
  for (std::size_t i = 0; i < rungs.size(); ++i)
    rungs[i].otherwise = rungs[i].cells == Rung::Cells::probe ? firstSoft : i + 1;
  return plan;
}

double secondsOf(const Rung& rung, double limit, double elapsed) {
  return limit > 0.0 ? std::max(Limits::leastSeconds, rung.share * (rung.until * limit - elapsed)) : 0.0;
}

std::optional<double> widerClearance(double succeeded, double failed) {
  if (failed == 0.0) return std::max(2.0 * succeeded, 16.0 * finestStep);
  if (failed - succeeded <= std::max(finestStep, finestShare * succeeded)) return {};
  return 0.5 * (succeeded + failed);
}

Rung widerRung(const Problem& problem, const Clearances& clearances) {
  Rung rung;
  rung.clearances = clearances;
  rung.most = problem.request.maxIterations.value_or(thoroughSweeps);
  rung.savesStates = false;
  return rung;
}

}  // namespace packmesh::hemocell
