// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What is true of a packing, however it is found.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "packMesh/container/container.h"
#include "packMesh/core/pose.h"
#include "packMesh/problem/species.h"

namespace packmesh {

/// The cells, the lumen, and what is required of them.
struct Physics {
  std::vector<Species> species;
  std::shared_ptr<const Container> container;
  /// Least gap between membranes [µm], guaranteed by the certificate. 0, the default, requires that no two
  /// meshes share a point, which is all that HemoCell needs and admits the densest packings; the gap achieved
  /// is reported.
  double clearance = 0.0;
  /// Least gap between membrane and wall [µm], guaranteed by the certificate.
  double wallClearance = 0.0;
  std::uint64_t seed = 1;
  bool rotate = true;  ///< false: every orientation stays the identity
  /// The pose as it will be written, so that the certificate refers to the written numbers; called by several
  /// threads at once. Empty: Pose::placement.
  std::function<Placement(const Pose&)> written = {};

  std::int64_t cellCount() const {
    std::int64_t cells = 0;
    for (const Species& one : species) cells += one.count;
    return cells;
  }
  /// The kind by which results name the cells of a species.
  int kindOf(int s) const { return species[s].kind < 0 ? s : species[s].kind; }
  const Shape& shapeOf(int s) const { return *species[s].shape; }
  /// The wall for a species; nullptr: none.
  const Wall* wallOf(const Species& one) const { return one.wall ? one.wall.get() : container->wall(); }
  const Wall* wallOf(int s) const { return wallOf(species[s]); }
  /// Least gap between cells of a species and their wall [µm].
  double wallClearanceOf(int s) const { return wallClearance + species[s].freedom.extraWallClearance; }
  /// The largest Shape::reach() [µm].
  double largestReach() const {
    double reach = 0.0;
    for (const Species& one : species) reach = std::max(reach, one.shape->reach());
    return reach;
  }
  /// A cell as it will be written if it is of full size.
  Placement placement(const Pose& pose) const {
    return written && pose.scale == 1.0 ? written(pose) : pose.placement();
  }
};

}  // namespace packmesh
