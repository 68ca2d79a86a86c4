// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/realisations.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/output/python_command.h"
#include "hemocell_adapter/output/realisation_table.h"
#include "hemocell_adapter/problem/realisation_folders.h"
#include "packMesh/io/atomic_files.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

/// The number of the first that is run.
std::int64_t firstOf(const Request& series) {
  return std::max<std::int64_t>(1, series.output.realisation);
}

/// The i-th realisation alone. The command stored in its state is that of the whole series, so that a restart
/// continues with the remaining ones.
CompletedRequest realisationOf(const CompletedRequest& series, std::int64_t i) {
  CompletedRequest one = series;
  const OutputRequest& ofAll = series.request.output;
  OutputRequest& output = one.request.output;
  one.request.realisations = 1;
  one.request.seed = series.request.seed + std::uint64_t(i - 1);
  output.realisation = i;
  output.realisationsOfAll = series.request.realisations;
  output.folder = ofAll.folder / realisationFolder(i, series.request.realisations);
  if (ofAll.stateFile) output.stateFile = output.folder / ofAll.stateFile->filename();
  if (ofAll.reportFile) output.reportFile = output.folder / ofAll.reportFile->filename();
  if (i != firstOf(series.request)) one.request.restart.reset();
  return one;
}

/// Cell files in the parent folder of the realisations belong to none of them, unless they are input.
void warnOfFilesBeside(const Request& request) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(request.output.folder, ignored)) {
    if (entry.path().extension() != ".pos") continue;
    const auto is = [&](const std::optional<Source>& source) {
      return source && fs::equivalent(entry.path(), source->file, ignored);
    };
    const auto isInput = [&](const SpeciesRequest& s) { return is(s.fixed) || is(s.start); };
    if (std::none_of(request.species.begin(), request.species.end(), isInput))
      log::warning(fmt::format(
          "{} belongs to none of the realisations; HemoCell, started in this folder, would read it",
          entry.path().string()));
  }
}

/// Mean and standard deviation of each figure, as packmesh prints them.
void tellSpread(const fs::path& table) {
  const std::vector<std::string> words = {"compare", table.string()};
  const CommandEnd end = runPackmesh(words, interrupted);
  for (const std::string& line : end.lines) log::info(line);
  if (end.kind != CommandEnd::Kind::done)
    log::info(fmt::format("For means and standard deviations: {}", asTyped(words)));
}

}  // namespace

ExitCode runRealisations(const CompletedRequest& series, const Communicator& ranks,
                         const std::function<RunEnd(const CompletedRequest&)>& run) {
  const Request& all = series.request;
  const std::int64_t first = firstOf(all);
  const fs::path file = all.output.folder / "realisations.csv";
  RealisationTable table(ranks.rank() == 0 ? file : fs::path(), first, all.seed);
  ExitCode worst = ExitCode::ok;
  std::string failed;
  const auto tellWritten = [&] {
    log::info(fmt::format("Realisations: {} of {} written", table.written(), all.realisations));
  };
  for (std::int64_t i = first; i <= all.realisations; ++i) {
    if (i > first && ranks.any(interrupted())) {  // while the one before was written
      tellWritten();
      log::error(fmt::format("interrupted: realisation {} was not begun", i));
      return ExitCode::interrupted;
    }
    const CompletedRequest one = realisationOf(series, i);
    log::info(fmt::format("Realisation {} of {}: seed {}, {}", i, all.realisations, one.request.seed,
                          one.request.output.folder.string()));
    const RunEnd end = run(one);
    if (end.code == ExitCode::interrupted) {
      tellWritten();
      return end.code;
    }
    table.add(i, one.request.seed, end.code, end.figures);
    onFirstRank(ranks, [&] {
      AtomicFiles files;
      files.add(file, table.text());
      files.commit();
    });
    if (end.code == ExitCode::ok) continue;
    failed += fmt::format("{}{}", failed.empty() ? "" : ", ", i);
    if (worst == ExitCode::ok) worst = end.code;
  }
  if (ranks.rank() == 0 && table.written() > 1) tellSpread(file);
  log::info(fmt::format("Wrote {}", file.string()));
  if (all.output.reportFile) {
    const fs::path report = all.output.folder / "realisation_*" / all.output.reportFile->filename();
    log::info(fmt::format("To compare them: packmesh compare {} --page compare.html",
                          fs::path(report).replace_extension(".json").string()));
  }
  tellWritten();
  if (ranks.rank() == 0) warnOfFilesBeside(all);
  if (!failed.empty()) log::error(fmt::format("realisations that failed: {}", failed));
  return worst;
}

}  // namespace packmesh::hemocell
