// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/fill.h"

#include <fmt/format.h>

#include <optional>

#include "hemocell_adapter/app/memory.h"
#include "hemocell_adapter/app/packing_attempts.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/output/cell_files.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/build_scene.h"
#include "hemocell_adapter/problem/make_job.h"
#include "packMesh/core/timer.h"

namespace packmesh::hemocell {
namespace {

Job jobOf(std::shared_ptr<const RunningCase> running, const std::vector<std::string>& words) {
  std::vector<std::string> all = {running->config.file.string()};
  all.insert(all.end(), words.begin(), words.end());
  return makeJob(parseCommandLine("packMesh", all), {}, std::move(running));
}

/// Cells with the numbers that HemoCell gives to those of .pos files.
Filling numbered(const Scene& scene, const PackingResult& result, const std::vector<std::int64_t>& counts,
                 const Communicator& ranks) {
  Filling filling;
  const std::size_t types = scene.running->cells.size();
  filling.counts.assign(types, 0);
  std::vector<std::int32_t> typeOf;  // of each species
  for (std::size_t s = 0; s < scene.species.size(); ++s) {
    const auto type = scene.running->cell(scene.species[s].name) - scene.running->cells.data();
    typeOf.push_back(static_cast<std::int32_t>(type));
    filling.counts[type] = counts[s];
  }
  std::vector<std::int64_t> next(types, 0), here(types, 0);
  for (std::size_t t = 1; t < types; ++t) next[t] = next[t - 1] + filling.counts[t - 1];
  for (const PlacedCell& cell : result.cells) ++here[typeOf[cell.species]];
  const std::vector<std::int64_t> all = ranks.gatherAll(here);
  for (int r = 0; r < ranks.rank(); ++r)
    for (std::size_t t = 0; t < types; ++t) next[t] += all[r * types + t];
  filling.cells.reserve(result.cells.size());
  for (const PlacedCell& cell : result.cells) {
    const std::int32_t type = typeOf[cell.species];
    filling.cells.push_back({type, next[type]++, cell.placement});
  }
  return filling;
}

/// Only cells that HemoCell keeps are added: it adds vertices where they are, and deletes cells on solid nodes.
void requireCertified(const Scene& scene, const PackingResult& result) {
  if (result.certificate.clean() && result.certificate.cells == result.cellCount) return;
  throw AgreedFailure({ExitCode::internal,
                       fmt::format("the packing failed verification ({} overlapping pairs, {} cells misplaced); no cells "
                                   "were added. This is an internal error; please report it with the case {}",
                                   result.certificate.overlapping.size(), result.certificate.misplaced.size(),
                                   scene.config->file.string())});
}

}  // namespace

Filling fill(std::shared_ptr<const RunningCase> running, const std::vector<std::string>& words,
             const Communicator& ranks) {
  const Timer timer;
  std::optional<Scene> built;
  together(ranks, [&] {
    Job job = jobOf(std::move(running), words);
    for (const std::string& warning : job.warnings) log::warning(warning);
    built = buildScene(std::move(job));
  });
  Scene& scene = *built;
  for (const std::string& notice : scene.notices) log::warning(notice);
  for (const std::string& line : headLines(scene, ranks.size())) log::info(line);
  together(ranks, [&] { requireMemory(scene.mostCells(), ranks); });

  PackingAttempts attempts(scene, ranks);
  PackingResult result = attempts.withRoom(timer).result;
  std::vector<std::int64_t> countsOfParts = namedBySpecies(scene, result);
  ranks.sum(countsOfParts);
  std::vector<std::int64_t> counts = countsOf(scene, result.cells);
  ranks.sum(counts);
  const Tally tally = tallyOf(scene, counts);
  if (result.outcome == Outcome::outOfReach) {
    const std::string reached = reachedText(scene, result, tally);
    if (!scene.bestEffort || result.cellCount == 0)
      throw AgreedFailure({ExitCode::outOfReach, reached + "; no cells were added (--best-effort adds those)"});
    log::warning(reached + "; adding those (--best-effort)");
  }
  requireCertified(scene, result);
  const RunTimes times = {timer.cpu(), timer.wall()};
  const Kept kept = {tally.counts, {}};  // by the certificate; counted once HemoCell has them
  for (const std::string& line : footLines(scene, tally, result.certificate, kept, times)) log::info(line);
  for (const std::string& line : regionLines(scene, countsOfParts)) log::info(line);
  if (scene.outputStated)
    for (const auto& file : writeCellFiles(scene, result, tally.counts, ranks))
      log::info(fmt::format("Wrote {}", file.string()));
  writeViews({scene, result, tally, kept, ranks, nullptr}, times);
  return numbered(scene, result, counts, ranks);
}

}  // namespace packmesh::hemocell
