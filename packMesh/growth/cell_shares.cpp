// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/cell_shares.h"

#include <algorithm>
#include <numeric>

#include "packMesh/core/box.h"

namespace packmesh {
namespace {

void bisect(const std::vector<Vec3>& centres, std::vector<int>::iterator begin,
            std::vector<int>::iterator end, int parts, std::vector<std::vector<int>>& out) {
  if (parts == 1) {
    out.emplace_back(begin, end);
    std::sort(out.back().begin(), out.back().end());
    return;
  }
  Vec3 size = Vec3::Zero();
  if (begin != end) {
    Box box{centres[*begin], centres[*begin]};
    for (auto i = begin; i != end; ++i) box.add(centres[*i]);
    size = box.size();
  }
  Eigen::Index axis = 0;
  size.maxCoeff(&axis);
  const int low = parts / 2;
  const auto middle = begin + (end - begin) * low / parts;
  std::nth_element(begin, middle, end, [&](int a, int b) {
    return centres[a][axis] != centres[b][axis] ? centres[a][axis] < centres[b][axis] : a < b;
  });
  bisect(centres, begin, middle, low, out);
  bisect(centres, middle, end, parts - low, out);
}

}  // namespace

std::vector<std::vector<int>> bisected(const std::vector<Vec3>& centres, int parts) {
  std::vector<int> all(centres.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<std::vector<int>> out;
  bisect(centres, all.begin(), all.end(), std::max(1, parts), out);
  return out;
}

CellShares::CellShares(const std::vector<Vec3>& centres, const Communicator& communicator)
    : communicator_(communicator) {
  if (communicator.alone()) return;
  owner_.resize(centres.size());
  int rank = 0;
  for (const std::vector<int>& part : bisected(centres, communicator.size())) {
    for (const int cell : part) owner_[cell] = rank;
    ++rank;
  }
}

std::vector<std::int64_t> CellShares::ownOf(const std::vector<std::int64_t>& cells) const {
  std::vector<std::int64_t> mine;
  for (const std::int64_t cell : cells)
    if (own(cell)) mine.push_back(cell);
  return mine;
}

}  // namespace packmesh
