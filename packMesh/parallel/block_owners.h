// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which rank works on which block.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/parallel/block_grid.h"

namespace packmesh {

/// Blocks in the order of a space-filling curve (Morton), cut into as many stretches of even work as there
/// are ranks. Ranks may own no block. The same on all ranks.
class BlockOwners {
 public:
  /// One rank owns all.
  BlockOwners() = default;
  /// @param work of each block, in any unit; what is empty costs nothing
  BlockOwners(const BlockGrid& blocks, const std::vector<std::int64_t>& work, int ranks);

  int of(int block) const { return owner_.empty() ? 0 : owner_[block]; }

 private:
  std::vector<std::int32_t> owner_;
};

}  // namespace packmesh
