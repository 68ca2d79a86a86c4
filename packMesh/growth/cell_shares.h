// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells of a state, which all ranks know, shared out for work.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/core/vector.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh {

/// Numbers 0 .. centres.size()-1 in `parts` groups of as even size as can be, each of points near each other:
/// cut in two across the longest side, and again (recursive coordinate bisection). Depends on nothing else.
/// Each group ascending.
std::vector<std::vector<int>> bisected(const std::vector<Vec3>& centres, int parts);

/// Which cells each rank works on. Every rank knows all cells, and who works on what.
class CellShares {
 public:
  /// This rank works on all.
  CellShares() = default;
  /// @param centres of all cells [µm]
  CellShares(const std::vector<Vec3>& centres, const Communicator& communicator);

  bool alone() const { return owner_.empty(); }
  bool own(std::int64_t cell) const { return alone() || owner_[cell] == communicator_.rank(); }
  int owner(std::int64_t cell) const { return alone() ? 0 : owner_[cell]; }
  const Communicator& communicator() const { return communicator_; }

  /// Those of `cells` that are this rank's.
  std::vector<std::int64_t> ownOf(const std::vector<std::int64_t>& cells) const;

 private:
  Communicator communicator_;
  std::vector<std::int32_t> owner_;  ///< empty: alone
};

}  // namespace packmesh
