// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells shared out among the ranks by their numbers, as they are placed and given back.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "packMesh/distributed/communicator.h"
#include "packMesh/stages/relaxation/body_state.h"

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

 private:
  std::int64_t cells_;
  Communicator communicator_;
};

}  // namespace packmesh
