// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/side_depth.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace packmesh {
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
