// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file In which order cells that may overlap massively are searched for overlapping pairs.
#pragma once

#include <algorithm>
#include <cstdint>

namespace packmesh {

/// A search of limited length: if all cells overlap, the number of pairs is quadratic in the number of cells.
///
/// Cells are searched in rounds, in the order of their numbers, each round twice as long as the one before. A
/// round in which too many pairs are found is given up and its pairs are forgotten, since which of them were
/// found depends on threads and ranks. Then it is known that at least `most` pairs overlap; only examples
/// are still looked for, from the first cell of that round on, if the rounds before have too few. The rounds
/// follow from the numbers of pairs alone, so they are the same on all ranks and for any number of them.
class OverlapSearch {
 public:
  /// Pairs that are enough as examples.
  static constexpr std::int64_t examples = 20;

  /// @param cells of all ranks
  /// @param most at which number of pairs the search ends
  explicit OverlapSearch(std::int64_t cells, std::int64_t most) : cells_(cells), most_(most) {}

  bool over() const { return begin_ >= cells_; }
  /// The cells of this round: first and one behind the last.
  std::int64_t begin() const { return begin_; }
  std::int64_t end() const { return std::min(begin_ + size_, cells_); }
  /// A round that finds as many pairs can end at once.
  std::int64_t room() const { return most_ - kept_; }
  /// Whether there are more pairs than can be listed; only examples are looked for.
  bool more() const { return more_; }

  /// Ends a round. @param found pairs of all ranks, at least room() if the round was ended early
  /// @return whether they are kept
  bool finish(std::int64_t found);

 private:
  std::int64_t cells_, most_, kept_ = 0;
  std::int64_t begin_ = 0, size_ = 1;
  bool more_ = false;
};

}  // namespace packmesh
