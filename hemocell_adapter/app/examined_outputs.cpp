// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/examined_outputs.h"

#include <fmt/format.h>

#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/output/cell_files.h"
#include "hemocell_adapter/output/outputs.h"

namespace packmesh::hemocell {

void writeOutputsOf(Scene scene, const FoundCells& found, const Examination& examination,
                    const RunTimes& times) {
  const Tally tally = tallyOf(scene, countsOf(scene, found.cells));
  for (std::size_t s = 0; s < tally.counts.size(); ++s) scene.species[s].count = tally.counts[s];
  if (scene.exports.empty() && viewFiles(scene).empty()) return;
  if (examination.certificate.moreOverlaps) {
    log::warning("so many cells overlap that nothing else is written");
    return;
  }
  requireWritableOutputs(scene);
  PackingResult result;
  result.cells = found.cells;
  result.poses = found.poses;
  result.cellCount = std::int64_t(found.cells.size());
  result.certificate = examination.certificate;
  Kept kept;
  kept.kept.assign(scene.species.size(), 0);
  for (const std::int64_t i : examination.kept) ++kept.kept[found.cells[i].species];
  for (const auto& violation : examination.violations)
    if (violation) countReason(kept, *violation, 1);
  const Communicator alone;
  if (!scene.exports.empty())
    for (const auto& file : writeExports(scene, result, tally.counts, alone))
      log::info(fmt::format("Wrote {}", file.string()));
  Finished done{scene, result, tally, kept, alone};
  done.checked = true;
  writeViews(done, times);
}

}  // namespace packmesh::hemocell
