// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/session.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/output/output_plan.h"
#include "hemocell_adapter/output/packing.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/counts.h"
#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/problem/plan_profile.h"
#include "hemocell_adapter/session/examination.h"
#include "hemocell_adapter/session/ladder.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"
#include "packMesh/core/poll.h"
#include "packMesh/packing/pack.h"
#include "packMesh/packing/problem_digest.h"
#include "packMesh/packing/state_file.h"

namespace packmesh::hemocell {
namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

/// The first number in a file; infinite if there is none.
double numberIn(const std::string& file) {
  std::ifstream in(file);
  double number = 0.0;
  return in >> number ? number : unlimited;
}

/// MemAvailable of /proc/meminfo.
double leftOnMachine() {
  std::ifstream in("/proc/meminfo");
  std::string name, unit;
  for (double kilobytes = 0.0; in >> name >> kilobytes; std::getline(in, unit))
    if (name == "MemAvailable:") return 1024.0 * kilobytes;
  return unlimited;
}

/// Of control groups as containers and batch systems set them (versions 2 and 1).
double leftInGroup() {
  const double second = numberIn("/sys/fs/cgroup/memory.max") - numberIn("/sys/fs/cgroup/memory.current");
  const double first = numberIn("/sys/fs/cgroup/memory/memory.limit_in_bytes") -
                       numberIn("/sys/fs/cgroup/memory/memory.usage_in_bytes");
  const auto known = [](double left) { return left >= 0.0 ? left : unlimited; };  // false for NaN
  return std::min(known(second), known(first));
}

double leftOfAddressSpace() {
  rlimit limit = {};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unlimited;
  const double used = numberIn("/proc/self/statm") * static_cast<double>(sysconf(_SC_PAGESIZE));
  return std::max(0.0, static_cast<double>(limit.rlim_cur) - (used < unlimited ? used : 0.0));
}

/// Ranks on this machine, as stated by the launcher; otherwise all of them may be.
int ranksHere(const Communicator& ranks) {
  for (const char* variable : {"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS"})
    if (const char* text = std::getenv(variable))
      if (const int number = std::atoi(text); number > 0) return number;
  return ranks.size();
}

}  // namespace

double availableMemory(const Communicator& ranks) {
  return std::min(std::min(leftOnMachine(), leftInGroup()) / ranksHere(ranks), leftOfAddressSpace());
}

void requireMemory(std::int64_t cells, const Communicator& ranks, double ofEach) {
  const double needed = ofEach * static_cast<double>(cells) / ranks.size(), left = availableMemory(ranks);
  if (needed <= left) return;
  constexpr double gigabyte = 1e9;
  throw InputError(
      fmt::format("not enough memory: {} {}cells take at least {:.3g} GB on each of {} rank{}, and {:.3g} GB "
                  "are left for each. Request fewer cells or use more machines",
                  cells, ofEach == leastOfDeformedCell ? "deformed " : "", needed / gigabyte, ranks.size(),
                  ranks.size() == 1 ? "" : "s", left / gigabyte));
}

void requireTileable(const Problem& problem) {
  double cells = 0.0, tiles = 1.0;
  const std::array<int, 3>& times = problem.request.tiles;
  for (const CellSpecies& species : problem.species) cells += double(species.count);
  for (int k = 0; k < 3; ++k) {
    tiles *= times[k];
    if (times[k] > 1 && !(problem.lumen.container->period()[k] > 0.0))
      throw InputError(fmt::format(
          named("tile") + ": the box is not periodic along {}, so it cannot be repeated", "xyz"[k]));
    if (times[k] * problem.lumen.container->bounds().size()[k] > specs::largestLength)
      throw InputError(fmt::format(named("tile") + ": the box would be more than {:.0f} µm long along {}",
                                   specs::largestLength, "xyz"[k]));
  }
  if (cells * tiles > specs::largestCount)
    throw InputError(fmt::format(named("tile") + ": {:.3g} cells are too many; at most {:.0f} can be packed",
                                 cells * tiles, specs::largestCount));
}

namespace {

/// The species of a larger box with their cells, which are all there. All ranks call.
std::vector<SpeciesPlan> tiledPlans(const Problem& problem, const PackingResult& result) {
  std::vector<PosLine> lines;
  for (const Pose& pose : result.poses) lines.push_back(problem.read->lineOf(pose));
  lines = problem.ranks.gatherAll(lines);
  const std::vector<PlacedCell> cells = problem.ranks.gatherAll(result.cells);
  std::vector<SpeciesPlan> plans(problem.species.begin(), problem.species.end());
  for (std::size_t s = 0; s < plans.size(); ++s) {
    SpeciesPlan& species = plans[s];
    species.fixed.clear();
    species.start.clear();
    species.ownTriangles = problem.species[s].shape->mesh().triangles;
    species.blood = {};
    species.fixedFrom.clear();
    species.startFrom = "the box that is repeated";
    species.ratio.reset();
  }
  const std::array<int, 3>& times = problem.request.tiles;
  const Vec3& box = *problem.request.boxSize;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const PlacedCell& cell = cells[i];
    std::vector<PresentCell>& images = plans[cell.species].start;
    for (int x = 0; x < times[0]; ++x)
      for (int y = 0; y < times[1]; ++y)
        for (int z = 0; z < times[2]; ++z) {
          images.emplace_back(PosLine{lines[i].position + Vec3(x, y, z).cwiseProduct(box), lines[i].angles});
          if (cell.shape != cell.species)
            images.back().vertices = problem.shapes[cell.shape]->mesh().vertices;
        }
  }
  for (SpeciesPlan& species : plans) species.statedCount = std::int64_t(species.start.size());
  return plans;
}

}  // namespace

Problem tiledProblem(const Problem& problem, const Clearances& clearances, const PackingResult& result) {
  CompletedRequest big{problem.request, problem.simulation, {}, {}};
  big.request.tiles = {1, 1, 1};
  big.request.regions.clear();
  big.request.inColumns = false;  // they are there
  big.request.profile.reset();
  big.request.dischargeHematocrit.reset();
  big.request.hematocrit.reset();
  for (int k = 0; k < 3; ++k) (*big.request.boxSize)[k] *= problem.request.tiles[k];
  return problemOfExistingCells(big, tiledPlans(problem, result), clearances, problem.ranks);
}

namespace {

std::string outOfTimeText(double maxSeconds, const Delivery& delivery) {
  return fmt::format("the time limit of {} was reached before packing began; {}", durationText(maxSeconds),
                     delivery.nothing);
}

/// What fixed cells have to do with it: "; 149 cells are fixed, and no place was found for 1 further cell".
std::string fixedText(const Packing& packing) {
  std::int64_t fixed = 0;
  for (const CellSpecies& species : packing.problem->species) fixed += std::int64_t(species.fixed.size());
  const std::int64_t missing = packing.problem->mostCells() - packing.cellCount;
  if (fixed == 0 || missing <= 0) return {};
  return fmt::format("; {} cell{} fixed, and no place was found for {} further cell{}", fixed,
                     fixed == 1 ? " is" : "s are", missing, missing == 1 ? "" : "s");
}

/// @throws InputError where undeformed cells cannot be packed, and deformed ones take too much
void requireMemoryDeformed(const Problem& problem, LumenSample& sample) {
  if (!problem.request.deforms()) return;
  std::int64_t cells = 0;
  for (const CellSpecies& species : problem.species)
    if (species.redCell && !species.rigid) cells += species.count;
  if (double(cells) * leastOfDeformedCell / problem.ranks.size() > availableMemory(problem.ranks) &&
      forecastOf(problem, sample).effectiveFraction > Forecast::possible)
    requireMemory(cells, problem.ranks, leastOfDeformedCell);
}

/// Why there is nothing to hand out if not all cells could be packed.
std::string failureText(const Packing& packing, const Delivery& delivery, LumenSample& sample) {
  const Problem& problem = *packing.problem;
  if (!packing.whyFewer.empty() && packing.cellCount == 0)
    return fmt::format("{}; {}. Fewer cells are easier", packing.whyFewer, delivery.nothing);
  const bool begun = packing.statistics.effort() > 0;
  if (packing.cellCount == 0 && !begun && problem.request.maxSeconds > 0.0)
    return outOfTimeText(problem.request.maxSeconds, delivery);
  const Forecast forecast = forecastOf(problem, sample);
  return reachedText(packing) + fixedText(packing) +
         (packing.cellCount == 0
              ? "; " + std::string(delivery.nothing)
              : fmt::format("; {} ({} {})", delivery.nothing, named("best-effort"), delivery.bestEffort)) +
         (forecast.effectiveFraction > Forecast::easy ? denserInstead(problem) : deformedInstead(problem)) +
         ". " + roomText(problem, forecast, sample);
}

/// Whether all cells are packed, or those that are suffice.
bool isEnough(const Packing& packing) {
  return packing.outcome != Outcome::outOfReach ||
         (packing.problem->request.bestEffort && packing.cellCount > 0);
}

/// @throws AgreedFailure unless all cells are packed, or those that are suffice
void requireEnough(const Packing& packing, const Delivery& delivery, LumenSample& sample) {
  if (!isEnough(packing)) throw AgreedFailure({ExitCode::outOfReach, failureText(packing, delivery, sample)});
  if (packing.outcome != Outcome::outOfReach) return;
  log::warning(fmt::format("{}; {} ({})", reachedText(packing), delivery.fewer, named("best-effort")));
}

/// @throws AgreedFailure if the certificate is not clean and complete, or if HemoCell would delete cells of a
/// packing of which it keeps all
void requireVerified(const Packing& packing, const Delivery& delivery) {
  const Certificate& certificate = packing.certificate;
  const Kept& kept = packing.kept;
  if (isClean(certificate, kept) && certificate.cells == packing.cellCount) return;
  throw AgreedFailure(
      {ExitCode::internal,
       fmt::format("the packing failed verification ({} of {} cells examined, {} overlapping pairs, {} "
                   "cells misplaced, {} self-intersecting, HemoCell would delete some: {}); {}. This is an "
                   "internal error; please report "
                   "it with the command",
                   certificate.cells, packing.cellCount, certificate.overlapping.size(),
                   certificate.misplaced.size(), certificate.selfIntersecting.size(),
                   kept.asExpected() ? "no" : kept.reasons.front().first, delivery.nothing)});
}

/// A problem of the cells that could be packed, with the numbers of those that were requested.
std::shared_ptr<const Problem> asRequested(const Problem& problem, const Problem& requested) {
  std::vector<std::int64_t> counts;
  for (const CellSpecies& species : requested.species) counts.push_back(species.count);
  auto made = std::make_shared<Problem>(problem);
  made->species = withCounts(std::move(made->species), counts);
  return made;
}

}  // namespace

std::function<void()> endOfPreparation(double maxSeconds, const Delivery& delivery,
                                       std::function<bool()> interrupted) {
  return [maxSeconds, delivery, asked = std::move(interrupted), timer = std::make_shared<const Timer>()] {
    if (asked && asked())
      throw AgreedFailure({ExitCode::interrupted, fmt::format("interrupted: {}", delivery.nothing)});
    if (maxSeconds > 0.0 && timer->wall() > maxSeconds)
      throw AgreedFailure({ExitCode::outOfReach, outOfTimeText(maxSeconds, delivery)});
  };
}

std::shared_ptr<const Problem> Session::prepare(const CompletedRequest& completed) {
  std::shared_ptr<const Problem> problem;
  together(ranks_, [&] {
    const PollScope scope(endOfPreparation(completed.request.maxSeconds, delivery_, hooks_.interrupted));
    problem = std::make_shared<const Problem>(problemToPack(completed, ranks_));
  });
  tell(problem->notices);
  if (problem->layout.profile && !completed.request.dryRun && !completed.request.validate)
    problem = correctByPilots(std::move(problem));
  if (const auto warning = missedHematocritWarning(*problem)) log::warning(*warning);
  if (completed.request.isTiled()) together(ranks_, [&] { requireTileable(*problem); });
  return problem;
}

/// Packs quickly with the clearances demanded, to see how the cells of a profile arrange themselves.
std::shared_ptr<const Problem> Session::correctByPilots(std::shared_ptr<const Problem> problem) const {
  constexpr int rounds = 2;
  constexpr std::int64_t sweeps = 600;
  const double most = problem->request.maxSeconds;
  for (int round = 0; round < rounds; ++round) {
    PackingProblem pilot = packingProblemOf(*problem, problem->atDemanded, [&] {
      return (hooks_.interrupted && hooks_.interrupted()) || (most > 0.0 && timer_.wall() > most);
    });
    pilot.execution.limits.maxSweeps = std::min(pilot.execution.limits.maxSweeps, sweeps);
    pilot.execution.limits.fewerCells = false;
    const PackingResult packed = packmesh::pack(pilot);
    if (packed.outcome != Outcome::certified) break;
    problem = std::make_shared<const Problem>(withCorrectedProfile(*problem, packed));
  }
  return problem;
}

Packing Session::pack(const std::shared_ptr<const Problem>& requested, const OutputRequest& output) {
  together(ranks_, [&] {
    requireMemory(requested->mostCells(), ranks_);
    requireMemoryDeformed(*requested, sampleOf(requested));
  });
  makeStateFolder(output, ranks_);
  Ladder ladder(requested, output, sampleOf(requested), hooks_, timer_);
  Packing packing = ladder.climb();
  stateSaved_ = ladder.saved();
  stateSavedOnce_ = ladder.savedAny();
  raise_ = packing.raise;
  if (packing.outcome == Outcome::interrupted) throwInterrupted(output);
  if (!packing.whyFewer.empty() && packing.cellCount < requested->mostCells()) {
    packing.outcome = Outcome::outOfReach;
    packing.problem = asRequested(*packing.problem, *requested);
  }
  packing = withTally(std::move(packing));
  const bool repeats = requested->request.isTiled() && isEnough(packing);
  packing = repeats ? repeatInTiles(std::move(packing)) : verify(std::move(packing));
  packing.times = {timer_.cpu(), timer_.wall()};
  return packing;
}

void Session::throwInterrupted(const OutputRequest& output) const {
  throw AgreedFailure(
      {ExitCode::interrupted,
       stateSaved_ ? fmt::format("interrupted: {}{}", delivery_.continueFrom, checkpointFile(output).string())
                   : fmt::format("interrupted: {}", delivery_.interrupted)});
}

LumenSample& Session::sampleOf(const std::shared_ptr<const Problem>& problem) {
  if (sampled_ != problem) {
    sample_.emplace(*problem);
    sampled_ = problem;
  }
  return *sample_;
}

Packing Session::verify(Packing packing) {
  requireEnough(packing, delivery_, sampleOf(packing.problem));
  const Problem& problem = *packing.problem;
  const std::vector<PlacedCell>& cells = packing.cells;
  packing.kept = delivery_.countedLater
                     ? Kept{Loading::plugIn, packing.tally.counts, excessVolumes(problem, cells), {}, {}}
                     : findKept(problem, cells, loadingOf(problem, cells));
  requireVerified(packing, delivery_);
  packing.deformations = deformationsOf(packing);
  return packing;
}

Packing Session::repeatInTiles(Packing before) {
  const Problem& problem = *before.problem;
  std::shared_ptr<const Problem> big;
  together(ranks_, [&] {
    big = std::make_shared<const Problem>(tiledProblem(problem, before.packed.clearances, before));
  });
  tell(big->notices);
  const auto& times = problem.request.tiles;
  log::info(
      fmt::format("Repeated {} x {} x {} times: {}", times[0], times[1], times[2], lumenLines(*big).front()));
  PackingProblem packing = packingProblemOf(*big, big->atDemanded, hooks_.interrupted);
  std::optional<PackingState> end;
  if (before.state)
    packing.checkpoints = Checkpoints{{}, [&](const PackingState& state) {
                                        if (isFinished(state, ranks_)) end = state;
                                      }};
  Packing done(packmesh::pack(packing));
  nameBySpecies(big->atDemanded, done);
  if (done.outcome == Outcome::interrupted)
    throw AgreedFailure({ExitCode::interrupted, fmt::format("interrupted: {}", delivery_.interrupted)});
  done.problem = big;
  done.output = before.output;
  done.packed = big->atDemanded;
  done.state = std::move(end);
  done = verify(withTally(std::move(done)));
  before.state.reset();
  done.before = std::make_shared<const Packing>(std::move(before));
  return done;
}

void logSummary(const Packing& packing) {
  for (const std::string& line : footLines(packing)) log::info(line);
  if (packing.deformations)
    for (const std::string& line : deformationLines(*packing.deformations)) log::info(line);
  const Problem& problem = *packing.problem;
  for (const std::string& line : bloodLines(packing, deformedCounts(problem, packing.cells))) log::info(line);
  for (const std::string& line : regionLines(packing)) log::info(line);
  if (!problem.layout.profile) return;
  for (const std::string& line : profileLines(problem, reachedProfile(problem, packing.cells)))
    log::info(line);
}

}  // namespace packmesh::hemocell
