// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The flags of a large lattice, which the ranks of a computer share, and what follows from them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

namespace packmesh::hemocell {

constexpr std::uint64_t allBits = ~std::uint64_t(0);

/// The bits of word w of a row that represent nodes.
inline std::uint64_t usedBits(int nodes, int w) {
  const int used = nodes - 64 * w;
  return used >= 64 ? allBits : used <= 0 ? 0 : (std::uint64_t(1) << used) - 1;
}

/// The bits of word w of a row that represent the nodes [from, to]. Pre: it has some
inline std::uint64_t bitsBetween(int from, int to, int w) {
  std::uint64_t bits = allBits;
  if (w == from >> 6) bits &= allBits << (from & 63);
  if (w == to >> 6) bits &= allBits >> (63 - (to & 63));
  return bits;
}

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
