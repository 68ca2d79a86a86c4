// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/soft_shares.h"

#include <algorithm>

#include "packMesh/parallel/blocks.h"

namespace packmesh {
namespace {

/// Edge of the blocks [µm]: smaller than a red cell, so that shares are equal.
constexpr double blockEdge = 4.0;

void sortOnce(std::vector<int>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

}  // namespace

SoftShares::SoftShares(const std::vector<Vec3>& centers, const std::vector<std::int64_t>& work,
                       const Communicator& ranks)
    : ranks_(ranks), owner_(centers.size(), 0), sends_(ranks.size()), receives_(ranks.size()) {
  if (!ranks.alone() && !centers.empty()) {
    Box bounds;
    for (const Vec3& p : centers) bounds.add(p);
    const BlockGrid blocks(bounds.grownBy(blockEdge), Vec3::Zero(), 0.5 * blockEdge, blockEdge);
    std::vector<std::int64_t> ofBlock(std::size_t(blocks.count()), 0);
    for (std::size_t i = 0; i < centers.size(); ++i) ofBlock[blocks.blockOf(centers[i])] += work[i];
    const BlockOwners owners(blocks, ofBlock, ranks.size());
    for (std::size_t i = 0; i < centers.size(); ++i) owner_[i] = owners.of(blocks.blockOf(centers[i]));
  }
  for (std::size_t i = 0; i < owner_.size(); ++i)
    if (isMine(i)) mine_.push_back(int(i));
}

void SoftShares::find(const SoftNeighbors& near) {
  if (ranks_.alone()) return;
  sends_.assign(ranks_.size(), {});
  receives_.assign(ranks_.size(), {});
  const auto need = [&](int cell, int other) {  // the rank of the first needs the other
    if (isMine(cell)) receives_[owner_[other]].push_back(other);
    if (isMine(other)) sends_[owner_[cell]].push_back(other);
  };
  for (std::size_t i = 0; i < near.size(); ++i)
    for (const auto& [j, shift] : near[i]) {
      if (owner_[i] == owner_[j]) continue;
      need(int(i), j);
      need(j, int(i));
    }
  others_.clear();
  for (std::vector<int>& cells : sends_) sortOnce(cells);
  for (std::vector<int>& cells : receives_) {
    sortOnce(cells);
    others_.insert(others_.end(), cells.begin(), cells.end());
  }
  std::sort(others_.begin(), others_.end());
}

void SoftShares::exchange(const Pack& pack, const Unpack& unpack) const {
  if (ranks_.alone()) return;
  std::vector<std::vector<float>> numbers(ranks_.size());
  for (std::size_t rank = 0; rank < numbers.size(); ++rank)
    for (const int i : sends_[rank]) pack(i, numbers[rank]);
  numbers = ranks_.exchange(std::move(numbers));
  for (std::size_t rank = 0; rank < numbers.size(); ++rank) {
    const float* from = numbers[rank].data();
    for (const int i : receives_[rank]) from = unpack(i, from);
  }
}

void SoftShares::gather(const Pack& pack, const Unpack& unpack) const {
  if (ranks_.alone()) return;
  std::vector<float> own;
  for (const int i : mine_) pack(i, own);
  const std::vector<float> all = ranks_.gatherAll(own);
  const float* from = all.data();
  for (int rank = 0; rank < ranks_.size(); ++rank)
    for (std::size_t i = 0; i < owner_.size(); ++i)
      if (owner_[i] == rank) from = unpack(int(i), from);
}

}  // namespace packmesh
