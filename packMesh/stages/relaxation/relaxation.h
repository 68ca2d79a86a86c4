// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Relaxation: overlapping rigid cells are pushed apart until none is in another's clearance.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "packMesh/distributed/block_grid.h"
#include "packMesh/stages/relaxation/body.h"
#include "packMesh/stages/relaxation/contact.h"
#include "packMesh/stages/relaxation/pair_list.h"

namespace packmesh {

/// What relaxation works on; plain data.
struct RelaxationInput {
  std::vector<const Shape*> shapes;  ///< per species
  std::vector<const Wall*> walls;    ///< per species; nullptr: none
  Box bounds;
  Vec3 period = Vec3::Zero();
  double clearance = 0.0;      ///< gap aimed at between membranes [µm]
  double wallClearance = 0.0;  ///< gap aimed at between membrane and wall [µm]
  bool rotate = true;
  std::uint64_t seed = 1;
};

/// Bodies, who is near whom, and the sweeps over them. The result of a sweep depends on the bodies and the
/// input alone: pairs are worked on block by block in the order of the blocks' colours.
class Relaxation {
 public:
  /// @param bodies in the order of their global ids
  Relaxation(const RelaxationInput& input, std::vector<Body> bodies);

  /// One Gauss-Seidel sweep over all near pairs and walls, after re-sorting the bodies into blocks if any has
  /// moved too far since this was done last.
  SweepSums sweep();

  /// Sweeps until no penetration is deeper than `tolerance` [µm], at most `maxSweeps` times, with a guard that
  /// lowers omega when the penetrations grow. `stop` is polled between sweeps.
  /// @return whether it got there
  bool settle(double tolerance, std::int64_t maxSweeps, const std::function<bool()>& stop);

  /// Gives every cell this scale [fraction].
  void setScale(double scale);

  /// Displaces every cell by a random vector of length up to `amplitude` [µm].
  void kick(double amplitude);

  /// A pair (ids) shall keep `extra` more clearance than it had [µm].
  void demandClearance(const PairKey& pair, double extra);
  /// A cell (id) shall keep `extra` more clearance from the wall [µm].
  void demandWallClearance(std::int64_t id, double extra);

  const std::vector<Body>& bodies() const { return bodies_; }
  /// Bodies in the order of their ids.
  std::vector<Pose> poses() const;
  std::int64_t sweeps() const { return sweeps_; }
  const SweepSums& lastSweep() const { return last_; }
  double omega() const { return omega_; }

 private:
  void refreshLists();
  bool listsOutdated() const;

  RelaxationInput input_;
  ContactSolver solver_;
  std::vector<double> radii_;
  BlockGrid blocks_;
  std::vector<std::vector<int>> blocksOfColour_;
  std::vector<Body> bodies_;
  std::vector<std::int64_t> bodyStart_;  ///< first body of each block
  std::vector<Vec3> listedAt_;           ///< positions when the lists were made
  PairList list_;
  std::map<PairKey, float> extraClearance_;
  bool listed_ = false;
  std::int64_t sweeps_ = 0;
  std::uint32_t kicks_ = 0;
  double omega_;
  double previousTotal_ = 0.0;
  int growing_ = 0;
  SweepSums last_;
};

}  // namespace packmesh
