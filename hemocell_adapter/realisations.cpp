// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/realisations.h"

#include <fmt/format.h>

#include "hemocell_adapter/log.h"

namespace packmesh::hemocell {

ExitCode runRealisations(const Job& job, const std::function<ExitCode(const Job&)>& run) {
  const std::string last = std::to_string(job.realisations);
  ExitCode worst = ExitCode::ok;
  std::int64_t good = 0;
  std::string failed;
  for (std::int64_t i = 1; i <= job.realisations; ++i) {
    const std::string folder = fmt::format("realisation_{:0{}}", i, last.size());
    Job one = job;
    one.realisations = 1;
    one.seed = job.seed + std::uint64_t(i - 1);
    one.outputDirectory = job.outputDirectory / folder;
    if (job.stateFile) one.stateFile = one.outputDirectory / job.stateFile->filename();
    if (job.reportFile) one.reportFile = one.outputDirectory / job.reportFile->filename();
    for (const std::string& word :
         {std::string("--realisations"), std::string("1"), std::string("--seed"), std::to_string(one.seed),
          std::string("--output-dir"), one.outputDirectory.string()})
      one.commandWords.push_back(word);
    if (job.stateFile) one.commandWords.insert(one.commandWords.end(), {"--state", one.stateFile->string()});
    if (job.reportFile)
      one.commandWords.insert(one.commandWords.end(), {"--report", one.reportFile->string()});
    log::info(
        fmt::format("Realisation {} of {}: seed {}, {}", i, last, one.seed, one.outputDirectory.string()));
    const ExitCode code = run(one);
    if (code == ExitCode::interrupted) {
      log::info(fmt::format("Realisations: {} of {} written", good, last));
      return code;
    }
    good += code == ExitCode::ok;
    if (code == ExitCode::ok) continue;
    failed += fmt::format("{}{}", failed.empty() ? "" : ", ", i);
    if (worst == ExitCode::ok) worst = code;
  }
  log::info(fmt::format("Realisations: {} of {} written", good, last));
  if (!failed.empty()) log::error(fmt::format("realisations that failed: {}", failed));
  return worst;
}

}  // namespace packmesh::hemocell
