// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/realisations.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/output/shared_files.h"
#include "hemocell_adapter/problem/realisation_folders.h"
#include "packMesh/io/atomic_files.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

/// The i-th realisation as a separate job. The command stored in its state is that of the whole series, so
/// that a restart continues with the remaining ones.
Job realisationOf(const Job& job, std::int64_t i) {
  Job one = job;
  one.realisations = 1;
  one.realisation = i;
  one.realisationsOfAll = job.realisations;
  one.seed = job.seed + std::uint64_t(i - 1);
  one.outputDirectory = job.outputDirectory / realisationFolder(i, job.realisations);
  if (job.stateFile) one.stateFile = one.outputDirectory / job.stateFile->filename();
  if (job.reportFile) one.reportFile = one.outputDirectory / job.reportFile->filename();
  if (i != job.firstRealisation) one.restart.reset();
  return one;
}

/// Cell files in the parent folder of the realisations belong to none of them, unless they are input.
void warnOfFilesBeside(const Job& job) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(job.outputDirectory, ignored)) {
    if (entry.path().extension() != ".pos") continue;
    const auto isInput = [&](const CellSpecies& s) {
      return fs::equivalent(entry.path(), s.fixedFrom, ignored) ||
             fs::equivalent(entry.path(), s.startFrom, ignored);
    };
    if (std::none_of(job.species.begin(), job.species.end(), isInput))
      log::warning(fmt::format(
          "{} belongs to none of the realisations; HemoCell, started in this folder, would read it",
          entry.path().string()));
  }
}

}  // namespace

ExitCode runRealisations(const Job& job, const Communicator& ranks,
                         const std::function<RunEnd(const Job&)>& run) {
  const fs::path file = job.outputDirectory / "realisations.csv";
  std::vector<Realisation> rows;
  if (ranks.rank() == 0) rows = readRealisations(file, job.firstRealisation, job.seed);
  ExitCode worst = ExitCode::ok;
  std::string failed;
  const auto tellWritten = [&] {
    const auto written =
        std::count_if(rows.begin(), rows.end(), [](const Realisation& r) { return r.written(); });
    log::info(fmt::format("Realisations: {} of {} written", written, job.realisations));
  };
  for (std::int64_t i = job.firstRealisation; i <= job.realisations; ++i) {
    const Job one = realisationOf(job, i);
    log::info(fmt::format("Realisation {} of {}: seed {}, {}", i, job.realisations, one.seed,
                          one.outputDirectory.string()));
    const RunEnd end = run(one);
    if (end.code == ExitCode::interrupted) {
      tellWritten();
      return end.code;
    }
    rows.push_back({i, one.seed, end.code, end.figures});
    onFirstRank(ranks, [&] {
      AtomicFiles files;
      files.add(file, realisationsText(rows));
      files.commit();
    });
    if (end.code == ExitCode::ok) continue;
    failed += fmt::format("{}{}", failed.empty() ? "" : ", ", i);
    if (worst == ExitCode::ok) worst = end.code;
  }
  for (const std::string& line : realisationLines(rows)) log::info(line);
  log::info(fmt::format("Wrote {}", file.string()));
  if (job.reportFile) {
    const fs::path report = job.outputDirectory / "realisation_*" / job.reportFile->filename();
    log::info(fmt::format("To compare them: python3 -m packmesh compare {} --page compare.html",
                          fs::path(report).replace_extension(".json").string()));
  }
  tellWritten();
  if (ranks.rank() == 0) warnOfFilesBeside(job);
  if (!failed.empty()) log::error(fmt::format("realisations that failed: {}", failed));
  return worst;
}

}  // namespace packmesh::hemocell
