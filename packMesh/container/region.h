// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Parts of a lumen.
#pragma once

#include "packMesh/container/container.h"

namespace packmesh {

class Region {
 public:
  virtual ~Region() = default;

  /// Positive inside [µm]; exact near the surface, elsewhere a lower bound of the distance (as for walls).
  virtual WallDistance distance(const Vec3& p) const = 0;
  bool contains(const Vec3& p) const { return distance(p).distance >= 0.0; }

  /// A box that contains the part of the region within the lumen's bounds.
  virtual const Box& bounds() const = 0;
};

}  // namespace packmesh
