// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace packmesh {
namespace {

/// Most blocks along an axis, so that the total fits an int.
constexpr double mostBlocks = 1000.0;

}  // namespace

BlockGrid::BlockGrid(const Box& bounds, const Vec3& period, double interactionRange, double preferredEdge)
    : bounds_(bounds) {
  const double edge = std::max(2.0 * interactionRange, preferredEdge);
  for (int k = 0; k < 3; ++k) {
    int n = edge > 0.0 ? std::max(1, static_cast<int>(std::min(bounds.size()[k] / edge, mostBlocks))) : 1;
    if (period[k] > 0.0 && n > 1) n -= n % 2;
    blocks_[k] = n;
    periodic_[k] = period[k] > 0.0;
    blocksPerLength_[k] = n / bounds.size()[k];
  }
}

Box BlockGrid::boxOf(int block) const {
  const std::array<int, 3> index = indexOf(block);
  Box box = bounds_;
  for (int k = 0; k < 3; ++k) {
    if (index[k] > 0) box.lo[k] = bounds_.lo[k] + index[k] / blocksPerLength_[k];
    if (index[k] + 1 < blocks_[k]) box.hi[k] = bounds_.lo[k] + (index[k] + 1) / blocksPerLength_[k];
  }
  return box;
}

int BlockGrid::blockOf(const Vec3& p) const {
  int index[3];
  for (int k = 0; k < 3; ++k) {
    const double b = std::floor((p[k] - bounds_.lo[k]) * blocksPerLength_[k]);
    index[k] = b <= 0.0 ? 0 : b >= blocks_[k] - 1 ? blocks_[k] - 1 : static_cast<int>(b);
  }
  return index[0] + blocks_[0] * (index[1] + blocks_[1] * index[2]);
}

std::array<int, 3> BlockGrid::indexOf(int block) const {
  return {block % blocks_[0], block / blocks_[0] % blocks_[1], block / blocks_[0] / blocks_[1]};
}

std::uint64_t BlockGrid::curvePosition(int block) const {
  const std::array<int, 3> index = indexOf(block);
  std::uint64_t position = 0;  // the bits of the three indices in turn
  for (int bit = 0; bit < 20; ++bit)
    for (int k = 0; k < 3; ++k) position |= static_cast<std::uint64_t>(index[k] >> bit & 1) << (3 * bit + k);
  return position;
}

int BlockGrid::colourOf(int block) const {
  const auto [i, j, k] = indexOf(block);
  return i % 2 + 2 * (j % 2) + 4 * (k % 2);
}

bool BlockGrid::has(int colour) const {
  for (int k = 0; k < 3; ++k)
    if ((colour >> k & 1) != 0 && blocks_[k] == 1) return false;
  return true;
}

double BlockGrid::largestRange() const {
  double range = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k)
    if (blocks_[k] > 1) range = std::min(range, 0.5 / blocksPerLength_[k]);
  return range;
}

std::vector<BlockGrid::Neighbor> BlockGrid::neighbors(int block) const {
  const std::array<int, 3> index = indexOf(block);
  std::vector<Neighbor> neighbors;
  for (int n = 0; n < 27; ++n) {
    const Step step = {static_cast<std::int8_t>(n % 3 - 1), static_cast<std::int8_t>(n / 3 % 3 - 1),
                       static_cast<std::int8_t>(n / 9 - 1)};
    if (step == Step{0, 0, 0}) continue;
    int at[3];
    bool there = true;
    for (int k = 0; k < 3; ++k) {
      at[k] = index[k] + step[k];
      if (periodic_[k]) at[k] = (at[k] + blocks_[k]) % blocks_[k];
      there = there && at[k] >= 0 && at[k] < blocks_[k];
    }
    if (there) neighbors.push_back({at[0] + blocks_[0] * (at[1] + blocks_[1] * at[2]), step});
  }
  return neighbors;
}

std::vector<int> BlockGrid::around(int block) const {
  std::vector<int> around = {block};
  for (const Neighbor& neighbor : neighbors(block)) around.push_back(neighbor.block);
  std::sort(around.begin(), around.end());
  around.erase(std::unique(around.begin(), around.end()), around.end());
  return around;
}

BlockGrid::FaceDistances BlockGrid::faceDistances(const Vec3& p, int block) const {
  const std::array<int, 3> index = indexOf(block);
  FaceDistances squared{};
  for (int k = 0; k < 3; ++k) {
    const double edge = 1.0 / blocksPerLength_[k], fromLow = p[k] - bounds_.lo[k] - index[k] * edge;
    const double before = std::max(0.0, fromLow), behind = std::max(0.0, edge - fromLow);
    squared[k] = {before * before, 0.0, behind * behind};
  }
  return squared;
}

double BlockGrid::squaredDistance(const Vec3& p, int block) const {
  const Box box = boxOf(block);
  const Vec3 size = bounds_.size();
  Vec3 offset = p - box.center();
  for (int k = 0; k < 3; ++k)
    if (periodic_[k]) offset[k] -= size[k] * std::round(offset[k] / size[k]);
  return (offset.cwiseAbs() - 0.5 * box.size()).cwiseMax(0.0).squaredNorm();
}

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
