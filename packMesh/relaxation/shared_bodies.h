// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Bodies on several ranks: ownership, and consistency of ghosts.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "packMesh/parallel/blocks.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/relaxation/body.h"

namespace packmesh {

/// A rank holds the bodies of its own blocks, and copies (ghosts) of those within a range of them: everything
/// that its blocks read or change. A rank that changes a body sends it to all ranks that hold it, before any
/// of them uses it again. Poses are sent, meshes are not.
///
/// All ranks call distribute(), beginGhostUpdate() and finishGhostUpdate() together. On one rank they do
/// nothing.
class SharedBodies {
 public:
  SharedBodies(const Communicator& communicator, const BlockGrid& blocks);
  SharedBodies(const SharedBodies&) = delete;  // lastForeign_ refers to a member
  SharedBodies& operator=(const SharedBodies&) = delete;

  bool owns(int block) const { return owners_.of(block) == rank_; }

  /// Redistributes the blocks. @param work of each block, as far as this rank knows: summed over the ranks
  void balance(std::vector<std::int64_t> work);

  /// Sends every body to the rank that owns its block, and ghosts to the ranks with a block nearer to it than
  /// `range` [µm]. Pre: `bodies` are this rank's own, each on one rank only, wrapped, blocks up to date.
  /// Post: its own bodies by the new distribution, and ghosts, sorted by block, then by id; data about the
  /// surroundings of bodies are discarded.
  void distribute(std::vector<Body>& bodies, double range);

  /// The bodies that another rank holds, too: indices, ascending. Pre: bodies as distribute() left them; the
  /// same holds below.
  const std::vector<std::int32_t>& shared() const { return shared_; }

  /// Begins to send the other ranks those of `candidates` (indices, ascending) that have `changed`; by
  /// default of all.
  void beginGhostUpdate(std::vector<Body>& bodies, const std::vector<std::int32_t>& candidates);
  void beginGhostUpdate(std::vector<Body>& bodies) { beginGhostUpdate(bodies, shared_); }
  /// Receives the changes of the other ranks. Pre: after beginGhostUpdate(); no shared body has been changed
  /// since.
  /// @return blocks of the bodies they changed, with repetitions
  std::vector<int> finishGhostUpdate(std::vector<Body>& bodies);
  /// Waits until all messages have been sent.
  void awaitGhostUpdate() const { communicator_.awaitSent(); }

 private:
  void plan(const std::vector<Body>& bodies, double range);
  /// Calls visit(rank) once for every rank that holds a body, starting with the owner.
  template <class Visit>
  void forEachHolder(const Body& body, double range, Visit&& visit);

  Communicator communicator_;
  BlockGrid blocks_;
  int rank_;
  BlockOwners owners_;
  /// Blocks of other ranks around each block, as far as they have been requested.
  struct ForeignNeighbor {
    int rank;
    BlockGrid::Step step;
  };
  /// Neighbours of a block that other ranks own, sorted by rank.
  const std::vector<ForeignNeighbor>& foreignTo(int block);
  std::map<int, std::vector<ForeignNeighbor>> foreign_;  ///< by block; as far as they were needed
  static constexpr int none = -1;
  int lastBlock_ = none;  ///< the last that was needed
  const std::vector<ForeignNeighbor>* lastForeign_ = nullptr;
  std::vector<Communicator::Peer> peers_;
  /// For each peer the bodies that it holds as well: indices, in the same order on both ranks.
  std::vector<std::vector<std::int32_t>> common_;
  std::vector<std::int32_t> shared_;  ///< of all peers together
};

}  // namespace packmesh
