// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Signed distances at points and nodes.
#pragma once

#include "packMesh/core/vector.h"

namespace packmesh {

struct DistanceSample {
  double distance;  ///< [µm]
  Vec3 gradient;    ///< of the distance
};

/// Nodes of a grid: (i,j,k) is at origin + spacing * (i,j,k) [µm].
struct NodeBlock {
  Vec3 origin = Vec3::Zero();
  double spacing = 1.0;
  int nodes[3] = {0, 0, 0};

  Vec3 position(int i, int j, int k) const { return origin + spacing * Vec3(i, j, k); }
};

/// Source of the values of a SampledDistance.
class DistanceSource {
 public:
  virtual ~DistanceSource() = default;

  /// Distances [µm] at the nodes of a block, x fastest.
  virtual void sample(const NodeBlock& block, float* distances) const = 0;
};

}  // namespace packmesh
