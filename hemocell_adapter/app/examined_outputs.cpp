// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/examined_outputs.h"

#include <fmt/format.h>

#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/output/cell_files.h"
#include "hemocell_adapter/output/outputs.h"

namespace packmesh::hemocell {

Kept keptOf(const FoundCells& found, const Examination& examination) {
  Kept all;
  all.kept = found.counts;
  for (const Examination::Dropped& one : examination.dropped) {
    --all.kept[found.placeOf(one.cell).species];
    countReason(all, examination.reasons[one.reason], 1);
  }
  return all;
}

void writeOutputsOf(Scene scene, const FoundCells& found, const Examination& examination,
                    const RunTimes& times, const Communicator& ranks) {
  const Tally tally = tallyOf(scene, found.counts);
  for (std::size_t s = 0; s < tally.counts.size(); ++s) scene.species[s].count = tally.counts[s];
  if (scene.exports.empty() && viewFiles(scene).empty()) return;
  if (examination.certificate.moreOverlaps) {
    log::warning("so many cells overlap that nothing else is written");
    return;
  }
  onFirstRank(ranks, [&] { requireWritableOutputs(scene, false); });
  PackingResult result;
  result.cells = found.cells;
  result.poses = found.poses;
  result.cellCount = found.all;
  result.certificate = examination.certificate;
  if (!scene.exports.empty())
    for (const auto& file : writeExports(scene, result, tally.counts, ranks))
      log::info(fmt::format("Wrote {}", file.string()));
  const Kept kept = keptOf(found, examination);
  Finished done{scene, result, tally, kept, ranks};
  done.checked = true;
  writeViews(done, times);
}

}  // namespace packmesh::hemocell
