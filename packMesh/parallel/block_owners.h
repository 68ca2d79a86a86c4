// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Assignment of blocks to ranks.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/parallel/block_grid.h"

namespace packmesh {

/// Blocks along a space-filling curve (Morton), divided into one section of equal work per rank. Some ranks
/// may own no blocks. Identical on all ranks.
class BlockOwners {
 public:
  /// One rank owns all blocks.
  BlockOwners() = default;
  /// @param work work of each block, in any unit; empty blocks have none
  BlockOwners(const BlockGrid& blocks, const std::vector<std::int64_t>& work, int ranks);

  int of(int block) const { return owner_.empty() ? 0 : owner_[block]; }

 private:
  std::vector<std::int32_t> owner_;
};

}  // namespace packmesh
