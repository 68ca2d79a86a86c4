// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Memory that the ranks of one computer share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "packMesh/parallel/communicator.h"

namespace packmesh {

/// A bit field that exists once on each computer (node) of a cluster: the ranks of a node set bits together
/// and then read them like memory of their own, without calls of MPI.
class NodeMemory {
 public:
  using Words = std::vector<std::pair<std::size_t, std::uint64_t>>;  ///< (number of a word, bits in it)

  /// Zeros, in which the bits of all ranks are set. All ranks call.
  /// @param ranksPerNode at most this many ranks share one field; for tests
  /// @throws std::runtime_error on all ranks if a node has too little shared memory
  NodeMemory(const Communicator& ranks, std::size_t size, const Words& bits,
             int ranksPerNode = std::numeric_limits<int>::max());
  /// All ranks call, unless an exception ends them.
  ~NodeMemory();
  NodeMemory(const NodeMemory&) = delete;
  NodeMemory& operator=(const NodeMemory&) = delete;

  std::uint64_t operator[](std::size_t word) const { return words_[word]; }

 private:
  struct Window;
  std::unique_ptr<Window> window_;
  std::vector<std::uint64_t> own_;  ///< of a single rank
  const std::uint64_t* words_ = nullptr;
};

}  // namespace packmesh
