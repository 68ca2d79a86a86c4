// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What grows, into what: the data that the parts of growth share.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "packMesh/container/container.h"
#include "packMesh/core/pose.h"
#include "packMesh/growth/cell_shares.h"
#include "packMesh/growth/plane_constraint.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// One cell while it grows.
struct GrowingCell {
  int species = 0;
  Pose pose;
  bool frozen = false;  ///< stays as it is; planes of others lie at its surface, not in the middle of the gap
};

/// The cells, in the order of their global numbers, centres within the container's bounds.
using GrowthState = std::vector<GrowingCell>;

/// Where cells grow; plain data, referenced.
struct GrowthScene {
  std::vector<const Shape*> shapes;  ///< per species
  std::vector<const Wall*> walls;    ///< per species; nullptr: none
  const Container* container = nullptr;
  double clearance = 0.0;      ///< least gap between membranes [µm]
  double wallClearance = 0.0;  ///< least gap between membrane and wall [µm]
  bool rotate = true;
  std::uint64_t seed = 1;
  /// The ranks that grow the cells together: all know all of them, each works on its share, and what comes
  /// out is the same on any number of ranks.
  Communicator communicator;
  /// Polled by single ranks within what takes long, TetGen's runs; true gives that up. Empty: never.
  std::function<bool()> stop = {};
  /// How a pose of scale 1 will be written; empty: Pose::placement.
  std::function<Placement(const Pose&)> written;

  Placement placement(const Pose& pose) const {
    return written && pose.scale == 1.0 ? written(pose) : pose.placement();
  }

  CellShares sharesOf(const GrowthState& state) const {
    if (communicator.alone()) return {};
    std::vector<Vec3> centres;
    for (const GrowingCell& cell : state) centres.push_back(cell.pose.position);
    return {centres, communicator};
  }
};

/// What is asked of a plane function.
struct PlaneRequest {
  /// How far any point of each cell may move in the step that the planes are for [µm].
  std::vector<double> reach;
  double detail = 1.0;  ///< share of the vertices to be used, eq. 3.4
  CellShares shares;    ///< planes are wanted of this rank's cells only; all ranks ask together
};

/// From a state that is free of overlap to the planes each cell has to stay behind. (Between two cells at
/// half the gap, so that both may come up to them at the same time.)
using PlaneFunction = std::function<PlaneConstraints(const GrowthState&, const PlaneRequest&)>;

}  // namespace packmesh
