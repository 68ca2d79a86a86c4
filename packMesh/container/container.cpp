// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/container.h"

namespace packmesh {

WallDistance Wall::distanceToSides(const Vec3& p, const std::array<bool, 3>& ends) const {
  const std::optional<ClosedFormWall> form = closedForm();
  return form ? form->without(ends).distance(p) : distance(p);
}

void Wall::sample(const NodeBlock& block, float* distances) const {
  for (int k = 0; k < block.nodes[2]; ++k)
    for (int j = 0; j < block.nodes[1]; ++j)
      for (int i = 0; i < block.nodes[0]; ++i)
        *distances++ = static_cast<float>(distance(block.position(i, j, k)).distance);
}

}  // namespace packmesh
