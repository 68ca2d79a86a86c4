// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/id_shares.h"

#include <algorithm>

namespace packmesh {

std::pair<std::int64_t, std::int64_t> IdShares::of(int rank) const {
  const std::int64_t ranks = communicator_.size(), each = cells_ / ranks, rest = cells_ % ranks;
  const auto start = [&](std::int64_t r) { return r * each + std::min(r, rest); };
  return {start(rank), start(rank + 1)};
}

std::vector<BodyState> IdShares::collect(const std::vector<Body>& bodies) const {
  std::vector<std::vector<BodyState>> to(communicator_.size());
  int rank = 0;
  for (const Body& body : bodies) {
    while (body.id >= of(rank).second) ++rank;
    to[rank].push_back(stateOf(body));
  }
  std::vector<BodyState> mine;
  for (std::vector<BodyState>& states : communicator_.exchange(to))
    mine.insert(mine.end(), states.begin(), states.end());
  std::sort(mine.begin(), mine.end(), [](const BodyState& a, const BodyState& b) { return a.id < b.id; });
  return mine;
}

}  // namespace packmesh
