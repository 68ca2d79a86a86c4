// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The flags of a large lattice, which the ranks of a computer share, and what follows from them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

namespace packmesh::hemocell {

/// Flags of nodes in rows along x: node i of a row is bit i % 64 of word i / 64; bits of no node are 0.
/// Threads can share it.
class LatticeView {
 public:
  explicit LatticeView(const std::array<int, 3>& nodes) : nodes_(nodes) {}
  virtual ~LatticeView() = default;
  LatticeView(const LatticeView&) = delete;
  LatticeView& operator=(const LatticeView&) = delete;

  const std::array<int, 3>& nodes() const { return nodes_; }
  int wordsPerRow() const { return (nodes_[0] + 63) / 64; }
  /// Word w of the row (j, k). Pre: it exists.
  virtual std::uint64_t word(int w, int j, int k) const = 0;

 private:
  std::array<int, 3> nodes_;
};

/// The nodes of another lattice that have no solid node within ±radius (see Lattice::eroded). Each word is
/// computed when it is read.
std::shared_ptr<const LatticeView> erodedView(std::shared_ptr<const LatticeView> of, int radius);

/// A lattice with margins of periodic images (see Lattice::repeated). Each word is put together when it is
/// read.
std::shared_ptr<const LatticeView> repeatedView(std::shared_ptr<const LatticeView> of,
                                                const std::array<int, 3>& margin);

}  // namespace packmesh::hemocell
