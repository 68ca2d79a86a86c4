// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which rank computes which soft cells, and what ranks tell each other of them.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/core/vector.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/parallel/threads.h"

namespace packmesh {

/// Of each cell: the cells near it, and their displacements to periodic images.
using SoftNeighbors = std::vector<std::vector<std::pair<int, Vec3>>>;

/// Finds those whose boxes are within a distance; among them the cell itself.
/// @param period of the lumen along each axis, 0 where it is not periodic [µm] @param reach [µm]
SoftNeighbors nearBoxes(const std::vector<Box>& boxes, const Vec3& period, double reach,
                        const Threads& threads);

/// Cells are divided among ranks by where they begin. Few are computed by the first rank alone: sending them
/// would take longer.
class SoftShares {
 public:
  SoftShares() = default;  ///< none
  /// @param centers of the cells [µm] @param work of each cell, in any unit
  SoftShares(const std::vector<Vec3>& centers, const std::vector<std::int64_t>& work,
             const Communicator& ranks);
  static constexpr std::size_t few = 16;  ///< as many as there are lanes

  /// All; and those that compute cells together, if this one does.
  const Communicator& ranks() const { return ranks_; }
  const Communicator& team() const { return team_; }
  bool isFirstAlone() const { return team_.size() < ranks_.size(); }
  bool computes() const { return !isFirstAlone() || ranks_.rank() == 0; }
  int ownerOf(std::size_t cell) const { return owner_[cell]; }
  bool isMine(std::size_t cell) const { return owner_[cell] == ranks_.rank(); }
  const std::vector<int>& mine() const { return mine_; }      ///< ascending
  const std::vector<int>& others() const { return others_; }  ///< of other ranks near them, ascending

  /// Finds the cells that ranks need of each other. `near` is the same on all ranks where one of two cells is
  /// theirs.
  void find(const SoftNeighbors& near);

  /// Appends the numbers of a cell; takes them over, and returns what follows them.
  using Pack = std::function<void(int cell, std::vector<float>& to)>;
  using Unpack = std::function<const float*(int cell, const float* from)>;
  /// Sends the numbers of cells to the ranks that need them. All ranks of the team call.
  void exchange(const Pack& pack, const Unpack& unpack);
  /// Sends those of all cells to all ranks, which all call.
  void gather(const Pack& pack, const Unpack& unpack) const;

  /// The numbers of the cells of this rank's IdShares, whose cells have these numbers as ids.
  /// @param pack appends those of a cell of this rank @param countOf any cell
  template <class T, class PackCell, class CountOf>
  std::vector<T> byIds(const PackCell& pack, const CountOf& countOf) const {
    const IdShares ids(std::int64_t(owner_.size()), ranks_);
    std::vector<std::vector<T>> parts(ranks_.size());
    const auto inShare = [&](int i, const std::pair<std::int64_t, std::int64_t>& share) {
      return i >= share.first && i < share.second;
    };
    for (int rank = 0; rank < ranks_.size(); ++rank) {
      const auto share = ids.of(rank);
      std::size_t count = 0;  // they are large
      for (const int i : mine_) count += inShare(i, share) ? std::size_t(countOf(i)) : 0;
      parts[rank].reserve(count);
      for (const int i : mine_)
        if (inShare(i, share)) pack(i, parts[rank]);
    }
    if (ranks_.alone()) return std::move(parts.front());
    parts = ranks_.exchange(std::move(parts));
    std::vector<std::size_t> used(parts.size(), 0);
    std::vector<T> all;
    for (std::int64_t i = ids.own().first; i < ids.own().second; ++i) {
      const auto from = parts[owner_[i]].begin() + std::ptrdiff_t(used[owner_[i]]);
      const std::size_t count = std::size_t(countOf(int(i)));
      all.insert(all.end(), from, from + std::ptrdiff_t(count));
      used[owner_[i]] += count;
    }
    return all;
  }

 private:
  Communicator ranks_, team_;
  std::vector<int> owner_, mine_, others_;
  std::vector<std::vector<int>> sends_, receives_;   ///< to and from each rank
  std::vector<std::vector<float>> sent_, received_;  ///< of them
};

}  // namespace packmesh
