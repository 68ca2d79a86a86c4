// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/run.h"

#include <fmt/format.h>

#include <numeric>
#include <optional>
#include <sstream>

#include "hemocell_adapter/app/memory.h"
#include "hemocell_adapter/app/packing_attempts.h"
#include "hemocell_adapter/app/realisations.h"
#include "hemocell_adapter/app/run_lock.h"
#include "hemocell_adapter/app/run_steps.h"
#include "hemocell_adapter/base/duration.h"
#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/output/cell_files.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/output/shared_files.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/build_scene.h"
#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/problem/scene.h"
#include "hemocell_adapter/problem/tiling.h"
#include "packMesh/core/timer.h"
#include "packMesh/packing/pack.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

/// Of the cells of all ranks.
Kept keptOf(const Scene& scene, const std::vector<PlacedCell>& cells, const Communicator& ranks) {
  Kept own;
  own.kept.assign(scene.species.size(), 0);
  if (!knowsAcceptance(scene)) return own;
  for (const PlacedCell& cell : cells) {
    if (const auto violation = hemocellViolation(scene, cell)) {
      countReason(own, *violation, 1);
    } else {
      ++own.kept[cell.species];
    }
  }
  std::string text;
  for (const auto& [reason, count] : own.reasons) text += fmt::format("{} {}\n", count, reason);
  const std::vector<char> all = ranks.gatherAll(std::vector<char>(text.begin(), text.end()));
  Kept kept;
  kept.kept = std::move(own.kept);
  ranks.sum(kept.kept);
  std::istringstream reasons(std::string(all.begin(), all.end()));
  std::int64_t count = 0;
  std::string reason;
  while (reasons >> count && reasons.ignore() && std::getline(reasons, reason))
    countReason(kept, reason, count);
  return kept;
}

ExitCode endInterrupted(const Job& job, bool saved) {
  if (saved)
    log::error(fmt::format("interrupted: no .pos was written; to continue: packMesh --restart {}",
                           job.stateFile->string()));
  else
    log::error("interrupted: nothing was written");
  return ExitCode::interrupted;
}

/// Why nothing is written if not all cells could be packed.
std::string failureText(const Scene& scene, const PackingResult& result, const Tally& tally) {
  const Statistics& done = result.statistics;
  const bool begun = done.effort() > 0;
  if (result.cellCount == 0 && !begun && scene.maxSeconds > 0.0)
    return fmt::format("the time limit of {} was reached before packing began; nothing was written",
                       durationText(scene.maxSeconds));
  return reachedText(scene, result, tally) +
         (result.cellCount == 0 ? "; not even one cell could be packed. Nothing was written"
                                : "; nothing was written (--best-effort writes that one)") +
         (forecastOf(scene).effectiveFraction > Forecast::easy ? columnsInstead(scene) : "");
}

RealisationFigures figuresOf(const Scene& scene, const PackingResult& result, const Tally& tally,
                             const RunTimes& times) {
  RealisationFigures figures;
  figures.complete = result.outcome != Outcome::outOfReach;
  figures.cells = result.cellCount;
  figures.hematocrit = tally.redMesh / scene.lumen.container->volume();
  figures.minimumGap = result.certificate.minimumGap;
  figures.minimumWallGap = result.certificate.minimumWallGap;
  figures.sweeps = result.statistics.effort();
  figures.cpuSeconds = times.cpu;
  figures.wallSeconds = times.wall;
  return figures;
}

/// For cells that cross periodic faces.
void warnOfDropped(const Scene& scene, const Tally& tally, const Kept& kept) {
  const auto sum = [](const std::vector<std::int64_t>& counts) {
    return std::accumulate(counts.begin(), counts.end(), std::int64_t(0));
  };
  log::warning(fmt::format(
      "HEMOCELL WOULD KEEP {} OF {} CELLS, A HEMATOCRIT OF {:.4f}: it silently deletes cells that cross a "
      "periodic face when it loads them; {} packs cells that it keeps",
      sum(kept.kept), sum(tally.counts), tallyOf(scene, kept.kept).redMesh / scene.referenceVolume(),
      scene.asPackCells ? "--keep-all (or the name packMesh)" : "--ends closed"));
}

/// Verifies that HemoCell keeps the cells, writes them, and prints the summary. Pre: species of the result
/// are parts.
RunEnd deliver(const Scene& scene, PackingResult& result, const Timer& timer, const Communicator& ranks,
               const Repeated* repeated = nullptr) {
  const Counted cells = counted(scene, result, ranks);
  const Tally& tally = cells.tally;
  if (result.outcome == Outcome::outOfReach) {
    if (!scene.bestEffort || result.cellCount == 0) {
      log::error(failureText(scene, result, tally));
      return {ExitCode::outOfReach, {}};
    }
    log::warning(reachedText(scene, result, tally) + "; writing that one (--best-effort)");
  }
  const Kept kept = keptOf(scene, result.cells, ranks);
  const bool allKept = kept.reasons.empty();
  const bool promised = scene.lumen.acceptedOnly && !scene.lumen.periodic;
  const bool complete = result.certificate.cells == result.cellCount;
  if (!result.certificate.clean() || !complete || (promised && !allKept)) {
    log::error(fmt::format(
        "the packing failed verification ({} of {} cells examined, {} overlapping pairs, {} cells misplaced, "
        "HemoCell "
        "would drop some: {}); nothing was written. This is an internal error; please report it with the "
        "command",
        result.certificate.cells, result.cellCount, result.certificate.overlapping.size(),
        result.certificate.misplaced.size(), allKept ? "no" : kept.reasons.front().first));
    return {ExitCode::internal, {}};
  }
  const RunTimes times = {timer.cpu(), timer.wall()};
  const std::vector<fs::path> files = writeCellFiles(scene, result, tally.counts, ranks);
  logSummary(scene, cells, result.certificate, kept, times);
  if (!allKept) warnOfDropped(scene, tally, kept);
  for (const fs::path& file : files) log::info(fmt::format("Wrote {}", file.string()));
  warnOfStaleFiles(scene);
  writeViews({scene, result, tally, kept, ranks, repeated}, times);
  return {ExitCode::ok, figuresOf(scene, result, tally, times)};
}

/// Repeats the packing in a larger box and certifies it again.
RunEnd deliverTiled(const Scene& scene, PackingResult& result, const Timer& timer,
                    const Communicator& ranks) {
  if (result.outcome == Outcome::outOfReach && !(scene.bestEffort && result.cellCount > 0))
    return deliver(scene, result, timer, ranks);
  namedBySpecies(scene, result);
  const Scene big = builtScene(tiledJob(scene, result, ranks), ranks);
  log::info(fmt::format("Repeated {} x {} x {} times: {}", scene.tiles[0], scene.tiles[1], scene.tiles[2],
                        lumenLines(big).front()));
  PackingProblem problem = problemOf(big, interrupted, {});
  problem.communicator = ranks;
  PackingResult bigResult = pack(problem);
  if (bigResult.outcome == Outcome::interrupted) {
    log::error("interrupted: nothing was written");
    return {ExitCode::interrupted, {}};
  }
  const Repeated repeated{scene, result};
  return deliver(big, bigResult, timer, ranks, &repeated);
}

bool writes(const Job& job) {
  return !job.dryRun && !job.validate;
}

/// Prevents other runs from writing the same files until the end of this one. Held by the first rank.
struct Locks {
  std::optional<RunLock> folder, state;
};

Locks locksOf(const Job& job, const Communicator& ranks) {
  Locks locks;
  onFirstRank(ranks, [&] {
    if (!writes(job)) return;
    locks.folder.emplace(RunLock::ofFolder(job.outputDirectory));
    if (job.stateFile) locks.state.emplace(RunLock::ofFile(*job.stateFile));
  });
  return locks;
}

/// Tests in advance whether the folders are writable.
void requireWritableFolders(const Job& job, const Communicator& ranks) {
  onFirstRank(ranks, [&] {
    requireWritable(job.outputDirectory);
    if (job.reportFile) requireWritable(job.reportFile->parent_path());
    if (!job.stateFile) return;
    requireWritable(job.stateFile->parent_path());
    requireReplaceableState(job);
  });
}

void tellForecast(const Scene& scene, const Communicator& ranks) {
  for (const std::string& line : forecastLines(scene, ranks.size())) log::info(line);
  log::info("A dry run: nothing was packed or written");
  if (const auto seconds = forecastOf(scene).seconds)
    log::detail(fmt::format("Expected CPU time: {:.4g} s", *seconds));
}

/// Packs the prepared scene and writes the result.
RunEnd packScene(Scene& scene, const Timer& timer, const Communicator& ranks) {
  together(ranks, [&] { requireMemory(scene.mostCells(), ranks); });
  pollInterruption();
  if (scene.stateFile) SharedFiles(ranks).makeFolder(scene.stateFile->parent_path());
  PackingAttempts attempts(scene, ranks);
  RoomyPacking packing = attempts.withRoom(timer);
  PackingResult& result = packing.result;
  if (result.outcome == Outcome::interrupted || ranks.any(interrupted()))
    return {endInterrupted(scene, attempts.saved()), {}};
  if (scene.largestClearance) setClearances(scene, packing.clearances);  // the last attempt may have failed
  RunEnd end =
      isTiled(scene) ? deliverTiled(scene, result, timer, ranks) : deliver(scene, result, timer, ranks);
  if (end.code != ExitCode::ok || !scene.stateFile || attempts.saved()) return end;
  log::error(fmt::format("{}: the state could not be saved", scene.stateFile->string()));
  end.code = ExitCode::cannotWrite;
  return end;
}

RunEnd packOnce(const Job& job, const Communicator& ranks) {
  const Timer timer;
  requireWritableFolders(job, ranks);
  const Locks locks = locksOf(job, ranks);
  for (const std::string& warning : job.warnings) log::warning(warning);
  Scene scene = builtScene(job, ranks);
  if (isTiled(job)) together(ranks, [&] { requireTileable(scene); });
  onFirstRank(ranks, [&] { requireWritableOutputs(scene); });
  if (job.validate) {
    log::info(fmt::format("{} is valid", job.config ? job.config->file.string() : "The command"));
    return {};
  }
  for (const std::string& line : headLines(scene, ranks.size())) log::info(line);
  log::detail(fmt::format("Preparation: {:.3f} s CPU", timer.cpu()));
  if (!job.dryRun) return packScene(scene, timer, ranks);
  tellForecast(scene, ranks);
  return {};
}

}  // namespace

ExitCode runPacking(const Job& job, const Communicator& ranks) {
  const auto once = [&](const Job& one) { return packOnce(one, ranks); };
  if (job.realisations == 1 || !writes(job)) return once(job).code;
  Job folder = job;
  folder.stateFile.reset();  // each realisation has its own
  const Locks locks = locksOf(folder, ranks);
  return runRealisations(job, ranks, once);
}

}  // namespace packmesh::hemocell
