// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "hemocell_adapter/app/realisations.h"
#include "hemocell_adapter/app/run_lock.h"
#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/output/cell_files.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/output/requested_outputs.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/completed_request.h"
#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/session/session.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

RealisationFigures realisationFigures(const Packing& packing) {
  return {packing.outcome != Outcome::outOfReach,
          packing.cellCount,
          packing.tally.redMesh / packing.problem->lumen.container->volume(),
          packing.certificate.minimumGap,
          packing.certificate.minimumWallGap,
          packing.statistics.effort(),
          packing.times.cpu,
          packing.times.wall};
}

/// How cells are packed of which HemoCell keeps all: those of .pos files with closed ends, where that is
/// possible.
std::string remedyOfDropped(const Packing& packing) {
  const Problem& problem = *packing.problem;
  const std::string plugIn = "the plug-in (packmesh::loadParticles) keeps all of them";
  const bool needsPeriod = packing.before || problem.request.inColumns ||
                           std::any_of(problem.species.begin(), problem.species.end(),
                                       [](const CellSpecies& species) { return !species.fixed.empty(); });
  if (needsPeriod) return plugIn;
  return fmt::format("{} packs cells that it keeps, {}",
                     problem.request.packCellsConventions ? named("keep-all") + " (or the name packMesh)"
                                                          : named("ends", "closed"),
                     plugIn);
}

/// For cells that cross periodic faces.
void warnOfDropped(const Packing& packing) {
  const Problem& problem = *packing.problem;
  const auto sum = [](const std::vector<std::int64_t>& counts) {
    return std::accumulate(counts.begin(), counts.end(), std::int64_t(0));
  };
  log::warning(fmt::format(
      "HemoCell would keep {} of {} cells, a hematocrit of {:.4f}: it silently deletes cells that cross a "
      "periodic face when it loads them from .pos files; {}",
      sum(packing.kept.kept), sum(packing.tally.counts),
      tallyOf(problem, packing.kept.kept, packing.kept.excess).redMesh / problem.referenceVolume(),
      remedyOfDropped(packing)));
}

/// Writes a packing that cannot be written as it was requested, to be written elsewhere later.
void rescue(const Packing& packing) {
  if (saveAsCheckpoint(*packing.problem, packing.output, {packing.packed, *packing.state}))
    log::warning(fmt::format(
        "The packing is saved in {0}; to write it elsewhere: packMesh --restart {0} --output-dir FOLDER",
        checkpointFile(packing.output).string()));
}

/// Writes the cells with the state of the packing, if one is requested; if they do not fit together, the
/// cells alone, unless only the state has them all.
/// @param stateWritten false: the state is missing
std::vector<fs::path> writeCells(const Packing& packing, bool& stateWritten) {
  const OutputRequest& output = packing.output;
  stateWritten = true;
  try {
    return writeCellFiles(packing, output, packing.state.has_value());
  } catch (const std::runtime_error&) {
    const Failure failure = failureOfException();
    if (!packing.state || failure.code != ExitCode::cannotWrite) throw;
    stateWritten = false;
    if (packing.problem->hasDeformed()) {
      rescue(packing);
      throw;
    }
    log::warning(failure.message);
  }
  try {
    return writeCellFiles(packing, output, false);
  } catch (const std::runtime_error&) {
    rescue(packing);
    throw;
  }
}

/// Writes the cells and everything else that is requested, and prints the summary.
/// @return false if the state is missing
bool write(const Packing& packing) {
  bool stateWritten = false;
  const std::vector<fs::path> files = writeCells(packing, stateWritten);
  logSummary(packing);
  if (!packing.kept.reasons.empty()) warnOfDropped(packing);
  for (const fs::path& file : files) log::info(fmt::format("Wrote {}", file.string()));
  warnOfStaleFiles(*packing.problem, packing.output);
  writeViews(packing);
  return stateWritten;
}

bool writes(const Request& request) {
  return !request.dryRun && !request.validate;
}

/// Prevents other runs from writing the same files until the end of this one. Held by the first rank.
struct Locks {
  std::optional<RunLock> folder, state;
};

/// From here on a signal does not end the run at once: there are files to remove.
Locks locksOf(const OutputRequest& output, const Communicator& ranks) {
  pollInterruption();
  Locks locks;
  onFirstRank(ranks, [&] {
    locks.folder.emplace(RunLock::ofFolder(output.folder));
    if (output.stateFile) locks.state.emplace(RunLock::ofFile(*output.stateFile));
  });
  return locks;
}

/// Tests in advance whether the folders are writable.
void requireWritableFolders(const Request& request, const OutputRequest& output, const Communicator& ranks) {
  onFirstRank(ranks, [&] {
    requireWritable(output.folder);
    if (output.reportFile) requireWritable(output.reportFile->parent_path());
    requireReplaceableState(request, output);
  });
}

ExitCode tellForecast(const Problem& problem) {
  const ForecastText forecast = forecastText(problem, problem.ranks.size());
  for (const std::string& line : forecast.lines) log::info(line);
  log::info("A dry run: nothing was packed or written");
  if (forecast.seconds) log::detail(fmt::format("Expected CPU time: {:.4g} s", *forecast.seconds));
  return forecast.impossible && !problem.request.bestEffort ? ExitCode::outOfReach : ExitCode::ok;
}

/// Packs and writes.
RunEnd packAndWrite(Session& session, const std::shared_ptr<const Problem>& problem,
                    const OutputRequest& output) {
  const Locks locks = locksOf(output, problem->ranks);
  std::optional<Packing> packing;
  try {
    packing = session.pack(problem, output);
  } catch (const AgreedFailure& failure) {
    log::error(failure.what());
    if (failure.code() == ExitCode::outOfReach && session.stateSaved())
      log::info(fmt::format("To continue with higher limits: packMesh --restart {} --max-time SECONDS",
                            checkpointFile(output).string()));
    return {failure.code(), {}};
  }
  if (!write(*packing)) {
    log::error(fmt::format("{}: the state could not be saved", output.stateFile->string()));
    return {ExitCode::cannotWrite, realisationFigures(*packing)};
  }
  if (output.stateFile)
    onFirstRank(problem->ranks,
                [&] { removeCheckpoint(problem->request, output, session.stateSavedOnce()); });
  return {ExitCode::ok, realisationFigures(*packing)};
}

RunEnd packOnce(const CompletedRequest& completed, const OutputRequest& output, const Communicator& ranks) {
  const Request& request = completed.request;
  Session session(writtenToFiles, {interrupted, {}}, ranks);
  requireWritableFolders(request, output, ranks);
  const std::shared_ptr<const Problem> problem = session.prepare(completed);
  onFirstRank(ranks, [&] { requireWritableOutputs(*problem, output, true); });
  if (request.validate) {
    log::info(
        fmt::format("{} is valid", problem->simulation ? problem->simulation->file.string() : "The command"));
    return {};
  }
  for (const std::string& line : headLines(*problem)) log::info(line);
  log::detail(fmt::format("Preparation: {:.3f} s CPU", session.timer().cpu()));
  if (!request.dryRun) {
    for (const std::string& line : reachLines(*problem, session.sampleOf(problem))) log::info(line);
    return packAndWrite(session, problem, output);
  }
  return {tellForecast(*problem), {}};
}

}  // namespace

ExitCode runPacking(const Request& asked, const Communicator& ranks) {
  CompletedRequest completed;
  OutputRequest output;
  together(ranks, [&] {
    completed = requestToPack(asked);
    output = outputsToPack(completed);
  });
  const Request& request = completed.request;
  if (request.realisations == 1 || !writes(request)) return packOnce(completed, output, ranks).code;
  OutputRequest folder = output;
  folder.stateFile.reset();  // each realisation has its own
  const Locks locks = locksOf(folder, ranks);
  return runRealisations(completed, output, ranks,
                         [&](const CompletedRequest& one, const OutputRequest& outputOfOne) {
                           return packOnce(one, outputOfOne, ranks);
                         });
}

}  // namespace packmesh::hemocell
