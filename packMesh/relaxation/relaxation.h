// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Relaxation: overlapping rigid cells are pushed apart, sweep by sweep.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "packMesh/parallel/block_grid.h"
#include "packMesh/relaxation/body.h"
#include "packMesh/relaxation/contact_solver.h"
#include "packMesh/relaxation/freedom.h"
#include "packMesh/relaxation/pair_list.h"
#include "packMesh/relaxation/relaxation_state.h"
#include "packMesh/relaxation/shared_bodies.h"

namespace packmesh {

/// What relaxation works on; plain data.
struct RelaxationInput {
  std::vector<const Shape*> shapes;  ///< per species
  std::vector<const Wall*> walls;    ///< per species; nullptr: none
  std::vector<Freedom> freedoms;     ///< per species; empty: all are free
  Box bounds;
  Vec3 period = Vec3::Zero();
  double clearance = 0.0;      ///< gap aimed at between membranes [µm]
  double wallClearance = 0.0;  ///< gap aimed at between membrane and wall [µm]
  bool rotate = true;
};

/// Bodies, who is near whom, and the sweeps over them. The result of a sweep depends on the bodies and the
/// input alone, not on the number of ranks: pairs are worked on block by block in the order of the blocks'
/// colours, and after each colour ranks send each other what changed.
///
/// All ranks call every function that is not const together, with the same arguments.
class Relaxation {
 public:
  /// @param bodies each on one rank, whichever
  /// @param state where to go on; bodies as they were then
  Relaxation(const RelaxationInput& input, std::vector<Body> bodies, const Communicator& communicator = {},
             const RelaxationState& state = {});

  /// One Gauss-Seidel sweep over all near pairs and walls, after re-sorting the bodies into blocks if any has
  /// moved too far since this was done last.
  /// @param omega over-relaxation: the fraction of each penetration that either direction of a contact takes
  /// away
  /// @param slack contacts are only resolved to within this of the clearance [µm]
  SweepSums sweep(double omega, double slack = 0.0);

  /// A pair (ids) shall keep `extra` more clearance than it had [µm].
  void demandClearance(std::int64_t first, std::int64_t second, double extra);
  /// Cell `id` shall keep `extra` more clearance from the wall [µm].
  void demandWallClearance(std::int64_t id, double extra);

  /// Takes cells out. Pre: `ids` sorted.
  void remove(const std::vector<std::int64_t>& ids);

  /// Whether the next sweep begins by finding out everything anew. Then the bodies and state() are all that
  /// the future depends on.
  bool beginsAnew() const;
  const RelaxationState& state() const { return state_; }

  /// Frees what can be found out anew, to leave its memory to others between sweeps, and lets every rank know
  /// the cells near its own. All ranks must call.
  void dropLists();

  /// Cells are known to all ranks with a cell from which they can be examined: whose mesh comes nearer than
  /// the certificate's gap of interest after both have moved by this [µm].
  static constexpr double certifiedMotion = 0.25;

  /// This rank's cells that have been moved since forgetTouched().
  std::vector<Body> touchedCells() const;
  void forgetTouched();

  /// This rank's cells in the order of their ids, positions wrapped into the bounds.
  std::vector<Body> cells() const;
  /// These, and the copies it has of cells near them.
  std::vector<Body> cellsAround() const;
  bool owns(const Body& body) const { return shared_.owns(body.block); }
  std::int64_t cellCount() const { return cellCount_; }  ///< of all ranks
  int blockCount() const { return blocks_.count(); }

  std::int64_t sweeps() const { return state_.sweeps; }
  const SweepSums& lastSweep() const { return state_.last; }
  /// Of the cell in the middle by volume [µm].
  double halfThickness() const { return halfThickness_; }

 private:
  /// A list of pairs lasts for so many sweeps at most, so that the course of long runs can be kept.
  static constexpr std::int64_t longestLived = 50;

  void refreshLists(bool sleeping);
  void addUp(SweepSums& sums);
  void resolve(int block, SweepSums& sums);
  void findBorder();
  bool atBorder(int block) const { return !atBorder_.empty() && atBorder_[block]; }
  void activate(int block);
  void activateAll();
  void activateDisturbed();
  bool isSleeping(double slack) const;
  void listPairsOfOwn();
  void shareOut(std::vector<std::int64_t> workOfBlock);
  bool isUneven() const;
  void expectMotion();
  double largestDisplacement() const;
  double allowedDisplacement() const;
  bool nearlyResolvedBefore() const;
  bool coarseWillDo() const;
  double range() const;
  std::vector<Body> cellsThat(const std::function<bool(const Body&)>& fit) const;
  void distribute();
  void dropCopies();

  RelaxationInput input_;
  Communicator communicator_;
  RelaxationState state_;
  std::int64_t cellCount_;
  ContactSolver solver_;
  std::vector<double> radii_;  ///< per species [µm]
  double halfThickness_;
  double largestRadius_;
  double largestReach_;  ///< of a cell as the certificate looks for neighbours [µm]
  BlockGrid blocks_;
  SharedBodies shared_;
  std::vector<std::vector<int>> blocksOfColour_;  ///< this rank's
  /// Blocks in which a sweep could change anything: where there was a contact in the last sweep, or a cell
  /// moved that one of the block's cells could meet.
  std::vector<char> active_;
  std::vector<char> atBorder_;  ///< blocks that could change a body that another rank holds; empty: none
  std::vector<Body> bodies_;    ///< own and copies, sorted by block, then by id
  std::vector<std::int64_t> bodyStart_;  ///< first body of each block; one past the last at the end
  std::vector<Vec3> listedAt_;           ///< positions when the lists were made
  PairList list_;
  double movedBefore_ = 0.0;  ///< sum over all cells when motion was last foreseen [µm]
  std::int64_t foreseenInSweep_ = 0;
  std::vector<std::int64_t> workOfBlock_;  ///< of this rank's, as last listed [pairs]
  bool listed_ = false;
  double displacement_ = 0.0;  ///< no cell is further than this from where it was when listed [µm]
  double largestExtra_ = 0.0;  ///< clearance of a pair [µm]
};

}  // namespace packmesh
