// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/run_steps.h"

#include <optional>
#include <string>
#include <utility>

#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/problem/build_scene.h"

namespace packmesh::hemocell {

Scene builtScene(const Job& job, const Communicator& ranks) {
  std::optional<Scene> scene;
  together(ranks, [&] { scene = buildScene(job); });
  for (const std::string& notice : scene->notices) log::warning(notice);
  return std::move(*scene);
}

Counted counted(const Scene& scene, PackingResult& result, const Communicator& ranks) {
  Counted counted;
  counted.parts = namedBySpecies(scene, result);
  ranks.sum(counted.parts);
  std::vector<std::int64_t> counts = countsOf(scene, result.cells);
  ranks.sum(counts);
  counted.tally = tallyOf(scene, std::move(counts));
  return counted;
}

void logSummary(const Scene& scene, const Counted& counted, const Certificate& certificate, const Kept& kept,
                const RunTimes& times) {
  for (const std::string& line : footLines(scene, counted.tally, certificate, kept, times)) log::info(line);
  for (const std::string& line : regionLines(scene, counted.parts)) log::info(line);
}

}  // namespace packmesh::hemocell
