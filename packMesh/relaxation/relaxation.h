// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Relaxation: overlapping rigid cells are pushed apart, sweep by sweep.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "packMesh/parallel/blocks.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"
#include "packMesh/relaxation/body.h"
#include "packMesh/relaxation/contact_solver.h"
#include "packMesh/relaxation/neighbor_list.h"
#include "packMesh/relaxation/shared_bodies.h"

namespace packmesh {

/// Bodies, the neighbour list, and the sweeps over them. Cells are kept apart by tolerance::relaxationMargin
/// more than the physics require. The result of a sweep depends on the bodies and the physics alone, not on
/// the number of ranks or threads: pairs are processed block by block in the order of the blocks' colours.
/// Blocks of a colour are independent, and after each colour the ranks exchange what has changed.
///
/// All ranks call every function that is not const together, with the same arguments.
///
/// relaxation.cpp has the distribution of the bodies and the neighbour list, relaxation_sweep.cpp the
/// sweeps.
class Relaxation {
 public:
  /// References the shapes and walls of `physics`, which must outlive it.
  /// @param bodies each on exactly one rank, no matter which
  /// @param state state to continue from; `bodies` are those of that state
  Relaxation(const Physics& physics, const Execution& execution, std::vector<Body> bodies,
             const RelaxationState& state = {});

  /// One Gauss-Seidel sweep over all near pairs and walls; the bodies are re-sorted into blocks before it if
  /// any has moved too far since the last time.
  /// @param omega over-relaxation factor: the fraction of each penetration that either direction of a contact
  ///   removes
  /// @param slack contacts are only resolved to within this of the clearance [µm]
  SweepSums sweep(double omega, double slack = 0.0);

  /// Increases the clearance of a pair (ids) by `extra` [µm].
  void demandClearance(std::int64_t first, std::int64_t second, double extra);
  /// Increases the wall clearance of cell `id` by `extra` [µm].
  void demandWallClearance(std::int64_t id, double extra);

  /// Removes cells. Pre: `ids` sorted.
  void remove(const std::vector<std::int64_t>& ids);

  /// Whether the next sweep begins by rebuilding everything. If so, the future depends on the bodies and
  /// state() alone.
  bool rebuildsNext() const;
  const RelaxationState& state() const { return state_; }

  /// Frees the lists, so that their memory can be used before a sweep that makes new ones. Pre:
  /// rebuildsNext()
  void forgetLists();

  /// Frees everything that can be recomputed, so that its memory can be used between sweeps, and updates the
  /// ghosts around the cells of each rank. All ranks must call.
  void dropLists();

  /// A rank has all cells that the examination of its own cells requires: those whose mesh comes nearer than
  /// the certificate's gap of interest after both have moved by this [µm].
  static constexpr double certifiedMotion = 0.25;

  /// This rank's cells that have been moved since forgetTouched(), as states().
  std::vector<BodyState> touchedStates() const;
  void forgetTouched();

  /// This rank's cells, sorted by id, positions wrapped into the bounds.
  std::vector<BodyState> states() const;
  /// The same in the order in which they are kept: quicker.
  std::vector<BodyState> unsortedStates() const;
  /// These and this rank's ghosts.
  std::vector<BodyState> statesAround() const;
  std::vector<Body> cells() const { return bodiesOf(states()); }
  bool owns(const BodyState& cell) const { return shared_.owns(cell.block); }
  std::int64_t cellCount() const { return cellCount_; }  ///< on all ranks
  /// Of these, the cells that are not fixed. Pre: remove() has removed no fixed ones
  std::int64_t movableCount() const { return cellCount_ - fixedCount_; }
  int blockCount() const { return blocks_.count(); }

  std::int64_t sweeps() const { return state_.sweeps; }
  const SweepSums& lastSweep() const { return state_.last; }
  /// Half the thickness of the cell of median volume [µm].
  double halfThickness() const { return halfThickness_; }

 private:
  /// A neighbour list is used for at most this many sweeps, so that the states of long runs can be saved.
  static constexpr std::int64_t longestLived = 50;

  /// Verlet skin of the neighbour list while cells move fast [fraction of the largest radius].
  static constexpr double widestSkin = 0.2;

  /// Interval at which the motion of the cells is measured [sweeps].
  static constexpr std::int64_t foreseenFor = 10;

  void refreshLists(bool sleeping);
  void addUp(SweepSums& sums);
  void resolve(int colour, bool border, SweepSums& sums);
  void resolve(int block, SweepSums& sums);
  void resolveTogether(int block, SweepSums& sums);
  int threadsForPairs() const;
  void findBorder(const std::vector<int>& blocks);
  bool atBorder(int block) const { return !atBorder_.empty() && atBorder_[block]; }
  void activate(int block);
  void activateAll();
  void activateDisturbed();
  bool isSleeping(double slack) const;
  void listPairs(std::vector<int> blocks);
  void listActive(int colour);
  void recordWork();
  void shareOut(std::vector<std::int64_t> workOfBlock);
  bool isUneven() const;
  void expectMotion();
  void forgetOverlaps();
  double largestDisplacement();
  template <class Visit>
  void forEachStirred(Visit&& visit) const;
  double allowedDisplacement() const;
  bool nearlyResolvedBefore() const;
  bool coarseWillDo() const;
  double range() const;
  template <class Fit>
  std::vector<BodyState> statesThat(Fit&& fit) const;
  BodyState wrappedState(const Body& body) const;
  Vec3 heldWithin(const Vec3& position) const;
  void distribute();
  void dropCopies();
  /// Calls visit(index, thread) for every body, own and ghosts.
  template <class Visit>
  void forEachBody(Visit&& visit) const {
    const auto bodies = static_cast<std::int64_t>(bodies_.size());
    threads_.forEachPart(bodies, [&](std::int64_t begin, std::int64_t end, int thread) {
      for (std::int64_t i = begin; i < end; ++i) visit(static_cast<std::size_t>(i), thread);
    });
  }

  Communicator communicator_;
  Threads threads_;
  Box bounds_;
  Vec3 period_;
  double clearance_;  ///< target gap between membranes [µm]
  RelaxationState state_;
  std::int64_t cellCount_, fixedCount_ = 0;
  ContactSolver solver_;
  std::vector<double> radii_;  ///< per shape [µm]
  double halfThickness_;
  double largestRadius_;
  double largestReach_;  ///< largest distance of a point of a cell from its centre [µm]
  BlockGrid blocks_;
  SharedBodies shared_;
  std::vector<std::vector<int>> blocksOfColour_;  ///< on this rank
  /// Blocks in which a sweep could change anything: those with a contact in the last sweep, and those where a
  /// cell moved that a cell of the block could touch.
  std::vector<char> active_;
  /// Blocks of which a cell may have moved in the last sweep. The others are passed over.
  std::vector<char> stirred_;
  std::vector<double> displacements_;     ///< per block: square of its cells' largest [µm²]
  std::vector<std::vector<int>> around_;  ///< BlockGrid::around() of the blocks for which it was needed
  std::vector<int> due_;                  ///< blocks being resolved; those without contacts become `none`
  static constexpr int none = -1;
  std::vector<char> atBorder_;  ///< blocks that could change a body that another rank holds; empty: none
  std::vector<Body> bodies_;    ///< own and ghosts, sorted by block, then by id
  std::vector<std::int64_t> bodyStart_;  ///< first body of each block; one past the last at the end
  std::vector<Vec3> listedAt_;           ///< positions at the last rebuild of the lists
  PairList list_;
  std::vector<char> isListed_;                      ///< per block, whether its pairs are
  std::vector<std::unique_ptr<PairOrder>> orders_;  ///< of the pairs of blocks that threads share
  /// While other programs occupy cores, so many blocks are resolved by one thread each before threads share
  /// one again, and how many are left.
  int pause_ = 0, pauseLeft_ = 0;
  /// Exists while pairs of some blocks are not listed: if cells sleep, they are when a cell comes near.
  std::optional<PairLister> lister_;
  bool mayBeDeep_ = true;  ///< whether pairs could be deep contacts at the last rebuild of the lists
  /// Per body that another rank holds: bit `c` is set if a block of colour `c` could change it.
  std::vector<std::uint8_t> exposed_;
  std::vector<char> isShared_;  ///< per body, whether another rank holds it
  /// The bodies exposed to each colour, ascending.
  std::array<std::vector<std::int32_t>, BlockGrid::colours> exposedTo_;
  double movedBefore_ = 0.0;  ///< sum over all cells at the last estimate of the motion [µm]
  std::int64_t foreseenInSweep_ = 0;
  std::vector<std::int64_t> workOfBlock_;  ///< on this rank, at the last rebuild of the lists [pairs]
  bool listed_ = false;
  double displacement_ = 0.0;  ///< largest displacement of a cell since the last rebuild [µm]
  double largestExtra_ = 0.0;  ///< largest extra clearance of a pair [µm]
};

}  // namespace packmesh
