// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Escape from local maxima of the coverage (thesis 3.1.3), for mixtures of shapes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "packMesh/cat/cat_settings.h"
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

/// Result of one phase: sums over all ranks, CPU time of this rank.
struct EscapePhase {
  std::string name;
  double coverage = 0.0;                ///< afterwards: volume of all cells as scaled / volume of the lumen
  std::int64_t cells = 0, full = 0;     ///< after the phase: number of cells; of full-size cells
  std::int64_t tried = 0, changed = 0;  ///< number of rooms or holes
  double seconds = 0.0;                 ///< CPU time [s]
};

/// Swaps cells, enlarges them, replaces them from a reserve and fills holes, in this order, and then grows
/// all cells. No phase lowers the coverage; every state is free of overlap. Full-size cells remain full-size
/// unless swapping them gains more volume elsewhere.
///
/// - Swapping: cells of a group, no two of which are neighbours, exchange places: each is scored by the
/// volume it
/// reaches in each room, and the bipartite matching with the largest sum is applied.
/// - Enlargement: cells below full size grow in their CAT cells, also from random orientations.
/// - Replacement: cells below full size are replaced by bodies from the reserve that reach more volume.
/// - Hole filling: circumspheres of tetrahedra in the free space, largest first, are rooms for bodies from
/// the
/// reserve; bodies that do not reach full size are rejected.
///
/// All phases but growth work block by block: blocks of one colour at the same time, each on the rank that
/// owns it. No rank has all cells, and states do not depend on the number of ranks. The reserve is divided
/// evenly among the blocks; what they leave is divided again among those that could use more.
/// @param stop asked between the blocks of two colours by all ranks together; the same on all. Within blocks,
///   Execution::interrupted abandons the work of this rank; then `stop` must become true
/// @param observe called after every phase with this rank's cells; can be empty
/// @param own this rank's cells, in any distribution; all together free of overlap. On return sorted by id;
///   cells can have been added, with the next free ids, and can have another species
/// @return the initial state and every phase
std::vector<EscapePhase> escape(const Physics& physics, const Execution& execution,
                                const GrowthSettings& growth, const EscapeSettings& settings,
                                const PlaneFunctionFactory& factory, const std::function<bool()>& stop,
                                const std::function<void(const std::vector<Body>&)>& observe,
                                std::vector<Body>& own);

}  // namespace packmesh
