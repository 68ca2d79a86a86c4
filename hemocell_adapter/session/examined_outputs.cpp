// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/examined_outputs.h"

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

void writeOutputsOf(const Problem& problem, const OutputRequest& output, const FoundCells& found,
                    const Examination& examination, const RunTimes& times) {
  if (output.exports.empty() && viewFiles(problem, output).empty()) return;
  if (examination.certificate.moreOverlaps) {
    log::warning("so many cells overlap that nothing else is written");
    return;
  }
  onFirstRank(problem.ranks, [&] { requireWritableOutputs(problem, output, false); });
  PackingResult result;
  result.cells = found.cells;
  result.poses = found.poses;
  result.cellCount = found.all;
  result.certificate = examination.certificate;
  const Tally tally = tallyOf(problem, found.counts);
  if (!output.exports.empty())
    for (const auto& file : writeExports(problem, output, result, tally.counts))
      log::info(fmt::format("Wrote {}", file.string()));
  const Kept kept = keptOf(found, examination);
  Finished done{problem, output, problem.demanded, result, tally, kept};
  done.checked = true;
  writeViews(done, times);
}

}  // namespace packmesh::hemocell
