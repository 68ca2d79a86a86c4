// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Neighbour list: the cells that may touch, sorted by the blocks that process them.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/parallel/periodic_images.h"
#include "packMesh/relaxation/contact_kernel.h"

namespace packmesh {

/// Two cells near each other: `second` displaced by `shift` periods is near `first`. A cell can be paired
/// with its own image.
struct ContactPair {
  std::int32_t first, second;  ///< indices into the bodies, first.id <= second.id
  ImageShift shift;
  bool deep = true;             ///< penetrated deeply at the last test: coarse samples suffice
  bool coarse = false;          ///< `touched` are clusters of the coarse samples
  std::uint8_t quickLooks = 0;  ///< since the last complete test of the pair
  float extraClearance = 0.0f;  ///< in addition to the problem's clearance [µm]
  /// The test of the pair is skipped until `moved`, the sum over both cells, reaches this [µm].
  float apartUntil = -1.0f;
  /// Until `moved` reaches this, only the clusters in the masks can touch the other cell [µm].
  float masksUntil = -1.0f;
  ClusterMask masks[2] = {allClusters, allClusters};
  /// The clusters that touched at the last complete test of the pair.
  ClusterMask touched[2] = {0, 0};
};

/// The pairs of each block, sorted by ids and shift.
using PairList = std::vector<std::vector<ContactPair>>;

}  // namespace packmesh
