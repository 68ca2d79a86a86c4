// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/run.h"

#include <fmt/format.h>

#include <numeric>
#include <optional>

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

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

ExitCode endInterrupted(const Job& job, bool saved) {
  if (saved)
    log::error(fmt::format("interrupted: no .pos was written; to continue: packMesh --restart {}",
                           job.stateFile->string()));
  else
    log::error("interrupted: nothing was written");
  return ExitCode::interrupted;
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
      "HemoCell would keep {} of {} cells, a hematocrit of {:.4f}: it silently deletes cells that cross a "
      "periodic face when it loads them; {} packs cells that it keeps",
      sum(kept.kept), sum(tally.counts), tallyOf(scene, kept.kept).redMesh / scene.referenceVolume(),
      scene.asPackCells ? "--keep-all (or the name packMesh)" : "--ends closed"));
}

/// Verifies that HemoCell keeps the cells, writes them, and prints the summary. Pre: species of the result
/// are parts.
RunEnd deliver(const Scene& scene, PackingResult& result, const Timer& timer, const Communicator& ranks,
               const Repeated* repeated = nullptr) {
  std::optional<Verified> checked;
  try {
    checked = verified(scene, result, ranks, writtenToFiles);
  } catch (const AgreedFailure& failure) {
    log::error(failure.what());
    return {failure.code(), {}};
  }
  const auto& [cells, kept] = *checked;
  const Tally& tally = cells.tally;
  const RunTimes times = {timer.cpu(), timer.wall()};
  const std::vector<fs::path> files = writeCellFiles(scene, result, tally.counts, ranks);
  logSummary(scene, cells, result.certificate, kept, times);
  if (!kept.reasons.empty()) warnOfDropped(scene, tally, kept);
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
  RepeatedPacking big = repeatedInTiles(scene, result, ranks, interrupted);
  if (big.result.outcome == Outcome::interrupted) {
    log::error("interrupted: nothing was written");
    return {ExitCode::interrupted, {}};
  }
  const Repeated repeated{scene, result};
  return deliver(big.scene, big.result, timer, ranks, &repeated);
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
  RunEnd end;
  try {
    end = isTiled(scene) ? deliverTiled(scene, result, timer, ranks) : deliver(scene, result, timer, ranks);
  } catch (...) {
    if (attempts.saved())
      log::warning(fmt::format(
          "The packing is saved in {0}; to write it elsewhere: packMesh --restart {0} --output-dir FOLDER",
          scene.stateFile->string()));
    throw;
  }
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
  Scene scene = builtScene(job, ranks, endOfPreparation(job, timer, writtenToFiles, interrupted));
  if (isTiled(job)) together(ranks, [&] { requireTileable(scene); });
  onFirstRank(ranks, [&] { requireWritableOutputs(scene, true); });
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
