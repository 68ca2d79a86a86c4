// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Distribution of cells over the ranks by id, for placement and for results.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "packMesh/parallel/communicator.h"
#include "packMesh/relaxation/body_state.h"

namespace packmesh {

/// Ids 0 .. cells-1 in equal shares, one per rank, in the order of the ranks.
class IdShares {
 public:
  IdShares(std::int64_t cells, Communicator communicator)
      : cells_(cells), communicator_(std::move(communicator)) {}

  /// The ids of a rank: [first, second).
  std::pair<std::int64_t, std::int64_t> of(int rank) const;
  std::pair<std::int64_t, std::int64_t> own() const { return of(communicator_.rank()); }

  /// This rank's share of the bodies that all ranks bring, each on one rank; both sorted by id. All ranks
  /// call it.
  std::vector<BodyState> collect(const std::vector<Body>& bodies) const;

  /// The same for any plain type with an `id`.
  template <class T>
  std::vector<T> collect(const std::vector<T>& items) const {
    std::vector<std::vector<T>> to(communicator_.size());
    int rank = 0;
    for (const T& item : items) {
      while (item.id >= of(rank).second) ++rank;
      to[rank].push_back(item);
    }
    std::vector<T> mine;
    mine.reserve(static_cast<std::size_t>(own().second - own().first));
    for (const std::vector<T>& some : communicator_.exchange(to))
      mine.insert(mine.end(), some.begin(), some.end());
    std::sort(mine.begin(), mine.end(), [](const T& a, const T& b) { return a.id < b.id; });
    return mine;
  }

 private:
  std::int64_t cells_;
  Communicator communicator_;
};

}  // namespace packmesh
