// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/id_shares.h"

namespace packmesh {

std::pair<std::int64_t, std::int64_t> IdShares::of(int rank) const {
  const std::int64_t ranks = communicator_.size(), each = cells_ / ranks, rest = cells_ % ranks;
  const auto start = [&](std::int64_t r) { return r * each + std::min(r, rest); };
  return {start(rank), start(rank + 1)};
}

std::vector<BodyState> IdShares::collect(std::vector<Body> bodies) const {
  std::vector<BodyState> states = statesOf(bodies);
  bodies.clear();
  bodies.shrink_to_fit();  // they are large
  return collect(std::move(states));
}

}  // namespace packmesh
