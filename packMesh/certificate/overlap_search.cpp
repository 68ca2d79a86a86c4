// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/overlap_search.h"

namespace packmesh {

bool OverlapSearch::finish(std::int64_t found) {
  const bool fits = found < room();
  const bool kept = fits || (more_ && size_ == 1);
  if (kept) {
    kept_ += found;
    begin_ = fits ? end() : cells_;
    size_ *= 2;
    return true;
  }
  if (!more_) most_ = examples;
  more_ = true;
  size_ = 1;
  if (kept_ >= most_) begin_ = cells_;
  return false;
}

}  // namespace packmesh
