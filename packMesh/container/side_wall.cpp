// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/side_wall.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace packmesh {

SideWall::SideWall(std::shared_ptr<const Container> lumen, const std::array<bool, 3>& ends)
    : lumen_(std::move(lumen)), ends_(ends), bounds_(lumen_->bounds()), form_(wall().closedForm()) {
  if (form_) form_ = form_->without(ends);
}

void SideWall::sample(const NodeBlock& block, float* distances) const {
  wall().sample(block, distances);
  for (int k = 0; k < block.nodes[2]; ++k)
    for (int j = 0; j < block.nodes[1]; ++j)
      for (int i = 0; i < block.nodes[0]; ++i, ++distances) {
        const Vec3 p = block.position(i, j, k);
        double toEnd = std::numeric_limits<double>::infinity();
        for (int axis = 0; axis < 3; ++axis)
          if (ends_[axis]) toEnd = std::min({toEnd, p[axis] - bounds_.lo[axis], bounds_.hi[axis] - p[axis]});
        constexpr double rounding = 1e-3;  // of distances in single precision [µm]
        if (*distances > toEnd - rounding) *distances = static_cast<float>(distance(p).distance);
      }
}

namespace {

constexpr double leastSpacing = 1.0, mostNodes = 3e5;

/// Cells that are being moved can leave the bounds, by less than this [µm].
constexpr double margin = 16.0;

}  // namespace

SideDepth::SideDepth(std::shared_ptr<const SideWall> wall, const Box& bounds)
    : wall_(std::move(wall)), bounds_(bounds), exactly_(wall_) {
  if (wall_->closedForm()) return;
  const double spacing = std::max(leastSpacing, std::cbrt(bounds.volume() / mostNodes));
  sampled_.emplace(exactly_, bounds.grownBy(margin), spacing);
}

}  // namespace packmesh
