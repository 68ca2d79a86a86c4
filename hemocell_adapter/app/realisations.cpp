// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/realisations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <system_error>

#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/python_command.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/problem/realisation_folders.h"
#include "packMesh/io/atomic_files.h"

namespace packmesh::hemocell {
namespace {

constexpr const char* head =
    "realisation,seed,outcome,cells,hematocrit,minimum_gap_um,minimum_wall_gap_um,sweeps,cpu_s,wall_s";

/// Empty if there is no such gap.
std::string gapField(double gap) {
  return std::isfinite(gap) ? fmt::format("{}", gap) : "";
}

std::string beginOf(std::int64_t number, std::uint64_t seed) {
  return fmt::format("{},{},", number, seed);
}

}  // namespace

RealisationTable::RealisationTable(const std::filesystem::path& file, std::int64_t first,
                                   std::uint64_t seed) {
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line) || line != head) return;
  const auto columns = std::count(line.begin(), line.end(), ',');
  while (std::getline(in, line)) {
    if (std::count(line.begin(), line.end(), ',') != columns) continue;
    for (std::int64_t i = 1; i < first; ++i)
      if (line.rfind(beginOf(i, seed + std::uint64_t(i - 1)), 0) == 0) rows_.push_back(line);
  }
}

void RealisationTable::add(std::int64_t number, std::uint64_t seed, ExitCode code,
                           const RealisationFigures& f) {
  const std::string begin = beginOf(number, seed);
  if (code != ExitCode::ok)
    rows_.push_back(begin + "failed,,,,,,,");
  else
    rows_.push_back(begin + fmt::format("{},{},{},{},{},{},{:.3f},{:.3f}",
                                        f.complete ? "certified" : "bestEffort", f.cells, f.hematocrit,
                                        gapField(f.minimumGap), gapField(f.minimumWallGap), f.sweeps,
                                        f.cpuSeconds, f.wallSeconds));
}

std::string RealisationTable::text() const {
  return fmt::format("{}\n{}\n", head, fmt::join(rows_, "\n"));
}

std::int64_t RealisationTable::written() const {
  return std::count_if(rows_.begin(), rows_.end(),
                       [](const std::string& row) { return row.find(",failed,") == std::string::npos; });
}

namespace {

namespace fs = std::filesystem;

/// The number of the first that is run.
std::int64_t firstOf(const OutputRequest& ofAll) {
  return std::max<std::int64_t>(1, ofAll.realisation);
}

/// The i-th realisation alone. The command stored in its state is that of the whole series, so that a restart
/// continues with the remaining ones.
CompletedRequest realisation(const CompletedRequest& series, const OutputRequest& ofAll, std::int64_t i) {
  CompletedRequest one = series;
  one.request.realisations = 1;
  one.request.seed = series.request.seed + std::uint64_t(i - 1);
  if (i != firstOf(ofAll)) one.request.restart.reset();
  return one;
}

/// What it writes, in its folder.
OutputRequest outputsOfRealisation(const OutputRequest& ofAll, std::int64_t i, std::int64_t all) {
  OutputRequest output = ofAll;
  output.realisation = i;
  output.realisationsOfAll = all;
  output.folder = ofAll.folder / realisationFolder(i, all);
  if (ofAll.stateFile) output.stateFile = output.folder / ofAll.stateFile->filename();
  if (ofAll.reportFile) output.reportFile = output.folder / ofAll.reportFile->filename();
  return output;
}

/// Cell files in the parent folder of the realisations belong to none of them, unless they are input.
void warnOfFilesBeside(const Request& request, const fs::path& folder) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
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

ExitCode runRealisations(const CompletedRequest& series, const OutputRequest& outputs,
                         const Communicator& ranks,
                         const std::function<RunEnd(const CompletedRequest&, const OutputRequest&)>& run) {
  const Request& all = series.request;
  const std::int64_t first = firstOf(outputs);
  const fs::path file = outputs.folder / "realisations.csv";
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
    const CompletedRequest one = realisation(series, outputs, i);
    const OutputRequest output = outputsOfRealisation(outputs, i, all.realisations);
    log::info(fmt::format("Realisation {} of {}: seed {}, {}", i, all.realisations, one.request.seed,
                          output.folder.string()));
    const RunEnd end = run(one, output);
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
  if (outputs.reportFile) {
    const fs::path report = outputs.folder / "realisation_*" / outputs.reportFile->filename();
    log::info(fmt::format("To compare them: packmesh compare {} --page compare.html",
                          fs::path(report).replace_extension(".json").string()));
  }
  tellWritten();
  if (ranks.rank() == 0) warnOfFilesBeside(all, outputs.folder);
  if (!failed.empty()) log::error(fmt::format("realisations that failed: {}", failed));
  return worst;
}

}  // namespace packmesh::hemocell
