// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/block_owners.h"

#include <algorithm>
#include <numeric>

namespace packmesh {
BlockOwners::BlockOwners(const BlockGrid& blocks, const std::vector<std::int64_t>& work, int ranks)
    : owner_(blocks.count(), 0) {
  std::vector<std::uint64_t> code(blocks.count());
  for (int b = 0; b < blocks.count(); ++b) code[b] = blocks.curvePosition(b);
  std::vector<int> order(blocks.count());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) { return code[a] < code[b]; });

  double left = static_cast<double>(std::accumulate(work.begin(), work.end(), std::int64_t(0)));
  double own = 0.0;
  int rank = 0;
  for (const int block : order) {
    // The next rank begins here if that brings this rank nearer to an equal share of the remaining work.
    const double share = left / (ranks - rank), more = static_cast<double>(work[block]);
    if (rank + 1 < ranks && own > 0.0 && own + 0.5 * more > share) {
      left -= own;
      own = 0.0;
      ++rank;
    }
    owner_[block] = rank;
    own += more;
  }
}

}  // namespace packmesh
