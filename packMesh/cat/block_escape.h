// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The phases of an escape within one block.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "packMesh/cat/cat_settings.h"
#include "packMesh/cat/holes.h"
#include "packMesh/cat/rooms.h"

namespace packmesh {

/// The assignment of rows to columns with the largest sum of scores: Hungarian algorithm with shortest
/// augmenting paths (H. Kuhn, Naval Research Logistics Quarterly 2, 1955; J. Munkres, J. SIAM 5, 1957),
/// O(n³).
/// @param scores square matrix; scores[row][column], finite
/// @return the column of each row
std::vector<int> bestAssignment(const std::vector<std::vector<double>>& scores);

/// Part of the reserve, per species.
struct ReserveShare {
  std::vector<std::int64_t> bodies;     ///< for this block
  std::vector<std::int64_t> elsewhere;  ///< for other blocks
};

/// Changes the cells of a block; those around it stay. What it does depends only on these cells, its share of
/// the reserve and the number of trials before, not on the rank.
class BlockEscape {
 public:
  /// References physics, settings, rooms and trials, which must outlive it.
  /// @param region the block
  /// @param cells of the block, sorted by id, then those within reach of it, marked as frozen
  /// @param firstId of cells that are added, with which their random numbers are made
  BlockEscape(const Physics& physics, const EscapeSettings& settings, Rooms& rooms, Rooms::Trials& trials,
              const Box& region, std::vector<Body> cells, std::int64_t firstId);

  void swap();
  void enlarge();
  void replace(ReserveShare& share);
  void fillHoles(const Holes& holes, ReserveShare& share);

  /// Changed and added cells among others.
  const std::vector<Body>& cells() const { return state_; }
  std::int64_t tried() const { return tried_; }      ///< number of rooms or holes
  std::int64_t changed() const { return changed_; }  ///< of these
  /// Whether bodies that were given to other blocks have been missed.
  bool missed() const { return missed_; }

 private:
  bool stopped() const { return trials_.stop && trials_.stop(); }
  double volume(int shape, double scale) const;
  double volumeOf(std::int64_t cell) const { return volume(state_[cell].shape, state_[cell].scale); }
  /// An undeformed body of a species.
  BodyKind kind(int species) const { return {species, physics_.species[species].shape}; }
  std::vector<std::int64_t> lacking() const;
  std::vector<std::int64_t> group(const std::vector<std::int64_t>& wanted) const;
  void swapWithin(const std::vector<std::int64_t>& members);
  bool take(std::int64_t cell, const BodyKind& kind);
  std::vector<int> bySize(const ReserveShare& share) const;
  bool usedUp(const ReserveShare& share);
  bool offered(int species, const ReserveShare& share);

  const Physics& physics_;
  const EscapeSettings& settings_;
  Rooms& rooms_;
  Rooms::Trials& trials_;
  Box region_;
  std::vector<Body> state_;
  std::int64_t nextId_;
  std::int64_t tried_ = 0, changed_ = 0;
  bool missed_ = false;
};

}  // namespace packmesh
