// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Search for the pairs of neighbour lists.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/mesh/sphere_grid.h"
#include "packMesh/parallel/threads.h"
#include "packMesh/relaxation/body.h"
#include "packMesh/relaxation/pair_list.h"

namespace packmesh {

/// Bodies among which pairs are searched. References only.
struct PairListerInput {
  const std::vector<Body>& bodies;         ///< wrapped into the bounds; sorted by block, then by id
  const std::vector<std::int64_t>& start;  ///< first body of each block; one past the last at the end
  const std::vector<double>& radii;        ///< per shape, of cells of scale 1 [µm]
  double margin = 0.0;                     ///< [µm]
  Box bounds;
  Vec3 period = Vec3::Zero();
};

/// Finds all pairs of bodies whose bounding spheres come nearer than the margin, each unordered pair of
/// images once, assigned to the block of the cell with the smaller id. Positions are those at construction.
class PairLister {
 public:
  explicit PairLister(const PairListerInput& input);

  /// Lists the pairs of blocks. @param list one entry per block; those of `blocks` are replaced
  void list(const std::vector<int>& blocks, const Threads& threads, PairList& list) const;

 private:
  struct Partner;
  void find(int body, std::vector<Partner>& partners, std::vector<ContactPair>& pairs) const;

  const PairListerInput input_;
  const std::vector<Sphere> spheres_;
  const SphereGrid grid_;
  std::vector<std::int64_t> ids_;
  double largest_ = 0.0;  ///< radius [µm]
};

}  // namespace packmesh
