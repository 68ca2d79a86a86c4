// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Sets of numbers that are joined one by one (union-find).
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace packmesh {

/// Disjoint sets of the numbers from 0 on, each named by its first member, whatever the order they are joined
/// in.
class UnionFind {
 public:
  /// Every number is a set of its own.
  explicit UnionFind(std::size_t count) : first_(count) { std::iota(first_.begin(), first_.end(), 0); }

  /// The smallest number in the set of i.
  int first(int i) {
    while (first_[i] != i) i = first_[i] = first_[first_[i]];
    return i;
  }

  /// Makes the sets of i and j one.
  void join(int i, int j) {
    i = first(i);
    j = first(j);
    first_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<int> first_;  ///< per number: its set's first member, or one on the way there
};

}  // namespace packmesh
