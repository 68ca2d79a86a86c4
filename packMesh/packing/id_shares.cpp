// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/id_shares.h"

namespace packmesh {

std::pair<std::int64_t, std::int64_t> IdShares::of(int rank) const {
  const std::int64_t ranks = communicator_.size(), each = cells_ / ranks, rest = cells_ % ranks;
  const auto start = [&](std::int64_t r) { return r * each + std::min(r, rest); };
  return {start(rank), start(rank + 1)};
}

std::vector<BodyState> IdShares::collect(std::vector<Body> bodies) const {
  std::vector<BodyState> states(bodies.begin(), bodies.end());
  bodies.clear();
  bodies.shrink_to_fit();  // they are large
  return collect(std::move(states));
}

CellMeasures IdShares::collect(const std::vector<std::int64_t>& ids, const CellMeasures& own) const {
  std::vector<MeasuresOfCell> measured;
  for (std::size_t i = 0; i < ids.size(); ++i) measured.push_back(measuresOfCell(own, i));
  measured = collect(ids, measured);
  CellMeasures all;
  all.resize(measured.size());
  for (std::size_t i = 0; i < measured.size(); ++i) setMeasuresOfCell(all, i, measured[i]);
  return all;
}

}  // namespace packmesh
