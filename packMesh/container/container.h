// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Interface of containers.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "packMesh/container/wall.h"
#include "packMesh/core/box.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// A lumen: extent, periodicity, volume and wall.
class Container {
 public:
  virtual ~Container() = default;

  /// Bounding box of the lumen [µm]; along a periodic axis it spans exactly one period.
  virtual Box bounds() const = 0;

  /// Period along each axis [µm], 0 where the container is not periodic.
  virtual Vec3 period() const = 0;

  /// The bounds and at least `margin` around them [µm]; for small cells all the same, so that samples of
  /// distances are shared.
  Box surroundings(double margin) const {
    constexpr double step = 16.0;
    return bounds().grownBy(step * std::max(1.0, std::ceil(margin / step)));
  }

  /// Volume of the lumen [µm³], of one period if it is periodic; see makeVessel for a vessel with continued
  /// ends.
  virtual double volume() const = 0;

  /// The wall, or nullptr if there is none (periodic along every axis).
  virtual const Wall* wall() const = 0;

  /// Description in one line: "periodic box 50 x 50 x 50 µm".
  virtual std::string describe() const = 0;

  /// Closed surface of the lumen, for pictures and engines.
  virtual TriangleMesh surface() const = 0;
};

}  // namespace packmesh
