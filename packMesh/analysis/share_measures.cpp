// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/analysis/share_measures.h"

#include "packMesh/certificate/shared_cells.h"

namespace packmesh {
namespace {

struct Measured {
  int index;
  MeasuresOfCell of;
};

}  // namespace

CellMeasures measureShare(const Physics& physics, const Execution& execution,
                          const std::vector<PlacedCell>& own, const std::set<std::int64_t>& outside,
                          double largestGap) {
  const Communicator& ranks = execution.communicator;
  const SharedCells here = sharedInSpace(own, physics, largestGap, ranks);
  std::vector<bool> leftOut;
  for (const std::int64_t number : here.numbers) leftOut.push_back(outside.count(number) > 0);
  CertificateInput input = certificateInputOf(physics, here.cells, execution.threads);
  input.own = &here.own;
  input.largestGap = largestGap;
  const CellMeasures found = measureCells(physics, execution, input, leftOut);

  std::vector<std::vector<Measured>> back(ranks.size());
  std::size_t n = 0;
  for (std::size_t i = 0; i < here.cells.size(); ++i) {
    if (!here.own[i]) continue;
    back[here.origins[i].rank].push_back({here.origins[i].index, measuresOfCell(found, n)});
    ++n;
  }
  CellMeasures measures;
  measures.resize(own.size());
  for (const std::vector<Measured>& some : ranks.exchange(back))
    for (const Measured& one : some) setMeasuresOfCell(measures, one.index, one.of);
  return measures;
}

}  // namespace packmesh
