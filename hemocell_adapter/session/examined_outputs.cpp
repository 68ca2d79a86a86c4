// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/examined_outputs.h"

#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/output/conversions.h"
#include "hemocell_adapter/output/outputs.h"

namespace packmesh::hemocell {

Kept keptOf(const FoundCells& found, const Examination& examination) {
  Kept all;
  all.loading = found.loading;
  all.kept = found.counts;
  all.excess = examination.excess;
  for (const Examination::Dropped& one : examination.dropped) {
    --all.kept[found.placeOf(one.cell).species];
    countReason(all, examination.reasons[one.reason], 1);
  }
  return all;
}

void withExamined(Problem problem, const OutputRequest& output, const FoundCells& found,
                  const Examination& examination, const std::function<void(const Finished&)>& use) {
  if (examination.certificate.moreOverlaps) {
    log::warning("so many cells overlap that nothing else is written");
    return;
  }
  auto read = std::make_shared<ReadLines>();
  for (const PosLine& line : found.lines) read->add(line);
  problem.read = std::move(read);
  for (std::size_t s = 0; s < found.counts.size(); ++s) problem.species[s].count = found.counts[s];
  PackingResult result;
  result.cells = found.cells;
  result.poses = found.poses;
  result.cellCount = found.all;
  result.certificate = examination.certificate;
  const Tally tally = tallyOf(problem, found.counts, found.excess);
  const Kept kept = keptOf(found, examination);
  Finished done{problem, output, problem.demanded, result, tally, kept};
  done.checked = true;
  use(done);
}

void writeOutputsOf(const Problem& problem, const OutputRequest& output, const FoundCells& found,
                    const Examination& examination, const RunTimes& times) {
  if (!output.asksForViews()) return;
  withExamined(problem, output, found, examination, [&](const Finished& done) {
    onFirstRank(done.ranks(), [&] { requireWritableOutputs(done.problem, output, false); });
    writeViews(done, times);
  });
}

}  // namespace packmesh::hemocell
