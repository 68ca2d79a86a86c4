// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which cells may touch, sorted into the blocks that work on them.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/distributed/block_grid.h"
#include "packMesh/distributed/periodic_images.h"
#include "packMesh/stages/relaxation/body.h"
#include "packMesh/stages/relaxation/contact_kernel.h"

namespace packmesh {

/// Two cells near each other: `second` displaced by `shift` periods is near `first`. A cell can be paired
/// with its own image.
struct ContactPair {
  int first, second;  ///< indices into the bodies, first.id <= second.id
  ImageShift shift;
  int epoch;  ///< what follows is about this epoch (see Body); `moved` is the sum over both cells [µm]
  double apartWhile;  ///< the two need not be looked at while moved is less than this
  double
      masksWhile;  ///< while moved is less than this, only the clusters in the masks can touch the other cell
  ClusterMask masks[2];
  bool deep;             ///< reached deep into each other when last looked at, so coarse samples will do
  float extraClearance;  ///< on top of the problem's clearance [µm]
};

struct PairList {
  std::vector<ContactPair> pairs;   ///< sorted by block, then by ids and shift
  std::vector<std::int64_t> start;  ///< first pair of each block; one past the last at the end
};

/// All pairs of bodies whose bounding spheres (radii per species, times scale) come nearer than `margin`,
/// each unordered pair of images once, assigned to the block of the cell with the smaller id. Pre: bodies
/// wrapped into the bounds.
PairList listPairs(const std::vector<Body>& bodies, const std::vector<double>& radii, double margin,
                   const Box& bounds, const Vec3& period, int blocks);

}  // namespace packmesh
