// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells shared out among the ranks by their numbers, as they are placed and given back.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "packMesh/parallel/communicator.h"
#include "packMesh/relaxation/body_state.h"

namespace packmesh {

/// Numbers 0 .. cells-1 in as many even shares as there are ranks, in the order of the ranks.
class IdShares {
 public:
  IdShares(std::int64_t cells, Communicator communicator)
      : cells_(cells), communicator_(std::move(communicator)) {}

  /// The numbers of a rank: [first, second).
  std::pair<std::int64_t, std::int64_t> of(int rank) const;
  std::pair<std::int64_t, std::int64_t> own() const { return of(communicator_.rank()); }

  /// What this rank has when each brings `bodies`, sorted by id, each on one rank: those of its share, sorted
  /// by id. All ranks call it.
  std::vector<BodyState> collect(const std::vector<Body>& bodies) const;

  /// The same for anything plain with an `id`.
  template <class T>
  std::vector<T> collect(const std::vector<T>& items) const {
    std::vector<std::vector<T>> to(communicator_.size());
    int rank = 0;
    for (const T& item : items) {
      while (item.id >= of(rank).second) ++rank;
      to[rank].push_back(item);
    }
    std::vector<T> mine;
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
