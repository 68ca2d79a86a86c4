// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/run.h"

#include <fmt/format.h>

#include <numeric>
#include <optional>

#include "hemocell_adapter/app/realisations.h"
#include "hemocell_adapter/app/run_lock.h"
#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/output/cell_files.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/completed_request.h"
#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/session/session.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

RealisationFigures figuresOf(const Packing& packing) {
  const PackingResult& result = packing.result;
  return {result.outcome != Outcome::outOfReach,
          result.cellCount,
          packing.cells.tally.redMesh / packing.problem->lumen.container->volume(),
          result.certificate.minimumGap,
          result.certificate.minimumWallGap,
          result.statistics.effort(),
          packing.times.cpu,
          packing.times.wall};
}

/// For cells that cross periodic faces.
void warnOfDropped(const Packing& packing) {
  const Problem& problem = *packing.problem;
  const auto sum = [](const std::vector<std::int64_t>& counts) {
    return std::accumulate(counts.begin(), counts.end(), std::int64_t(0));
  };
  log::warning(fmt::format(
      "HemoCell would keep {} of {} cells, a hematocrit of {:.4f}: it silently deletes cells that cross a "
      "periodic face when it loads them; {} packs cells that it keeps",
      sum(packing.kept.kept), sum(packing.cells.tally.counts),
      tallyOf(problem, packing.kept.kept, packing.kept.excess).redMesh / problem.referenceVolume(),
      problem.request.packCellsConventions ? "--keep-all (or the name packMesh)" : "--ends closed"));
}

/// Writes the cells and everything else that is requested, and prints the summary.
void write(const Packing& packing) {
  const Problem& problem = *packing.problem;
  const OutputRequest& output = problem.request.output;
  const std::vector<fs::path> files =
      writeCellFiles(problem, output, packing.result, packing.cells.tally.counts);
  logSummary(packing);
  if (!packing.kept.reasons.empty()) warnOfDropped(packing);
  for (const fs::path& file : files) log::info(fmt::format("Wrote {}", file.string()));
  warnOfStaleFiles(problem, output);
  writeViews(finishedOf(packing, output), packing.times);
}

bool writes(const Request& request) {
  return !request.dryRun && !request.validate;
}

/// Prevents other runs from writing the same files until the end of this one. Held by the first rank.
struct Locks {
  std::optional<RunLock> folder, state;
};

/// @param writes false: nothing will be written
Locks locksOf(const OutputRequest& output, bool writes, const Communicator& ranks) {
  Locks locks;
  onFirstRank(ranks, [&] {
    if (!writes) return;
    locks.folder.emplace(RunLock::ofFolder(output.folder));
    if (output.stateFile) locks.state.emplace(RunLock::ofFile(*output.stateFile));
  });
  return locks;
}

/// Tests in advance whether the folders are writable.
void requireWritableFolders(const Request& request, const Communicator& ranks) {
  onFirstRank(ranks, [&] {
    const OutputRequest& output = request.output;
    requireWritable(output.folder);
    if (output.reportFile) requireWritable(output.reportFile->parent_path());
    if (output.stateFile) requireReplaceableState(request);
  });
}

void tellForecast(const Problem& problem) {
  for (const std::string& line : forecastLines(problem, problem.ranks.size())) log::info(line);
  log::info("A dry run: nothing was packed or written");
  if (const auto seconds = forecastOf(problem).seconds)
    log::detail(fmt::format("Expected CPU time: {:.4g} s", *seconds));
}

/// Packs and writes.
RunEnd packAndWrite(Session& session, const std::shared_ptr<const Problem>& problem) {
  pollInterruption();
  const std::optional<fs::path>& stateFile = problem->request.output.stateFile;
  std::optional<Packing> packing;
  try {
    packing = session.pack(problem);
  } catch (const AgreedFailure& failure) {
    log::error(failure.what());
    return {failure.code(), {}};
  }
  try {
    write(*packing);
  } catch (...) {
    if (session.stateSaved())
      log::warning(fmt::format(
          "The packing is saved in {0}; to write it elsewhere: packMesh --restart {0} --output-dir FOLDER",
          stateFile->string()));
    throw;
  }
  if (!stateFile || session.stateSaved()) return {ExitCode::ok, figuresOf(*packing)};
  log::error(fmt::format("{}: the state could not be saved", stateFile->string()));
  return {ExitCode::cannotWrite, figuresOf(*packing)};
}

RunEnd packOnce(const CompletedRequest& completed, const Communicator& ranks) {
  const Request& request = completed.request;
  Session session(writtenToFiles, {interrupted, {}}, ranks);
  requireWritableFolders(request, ranks);
  const Locks locks = locksOf(request.output, writes(request), ranks);
  const std::shared_ptr<const Problem> problem = session.problemOf(completed);
  onFirstRank(ranks, [&] { requireWritableOutputs(*problem, request.output, true); });
  if (request.validate) {
    log::info(
        fmt::format("{} is valid", problem->simulation ? problem->simulation->file.string() : "The command"));
    return {};
  }
  for (const std::string& line : headLines(*problem)) log::info(line);
  log::detail(fmt::format("Preparation: {:.3f} s CPU", session.timer().cpu()));
  if (!request.dryRun) return packAndWrite(session, problem);
  tellForecast(*problem);
  return {};
}

}  // namespace

ExitCode runPacking(const CommandLine& commandLine, const Communicator& ranks) {
  CompletedRequest completed;
  together(ranks, [&] { completed = requestToPack(commandLine); });
  const Request& request = completed.request;
  if (request.realisations == 1 || !writes(request)) return packOnce(completed, ranks).code;
  OutputRequest folder = request.output;
  folder.stateFile.reset();  // each realisation has its own
  const Locks locks = locksOf(folder, true, ranks);
  return runRealisations(completed, ranks, [&](const CompletedRequest& one) { return packOnce(one, ranks); });
}

}  // namespace packmesh::hemocell
