// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/sampled_wall.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace packmesh {

SampledWall::SampledWall(const Wall& wall, const Box& region)
    : wall_(wall), spacing_(wall.samplingSpacing()) {
  for (int k = 0; k < 3; ++k) {
    lo_[k] = static_cast<int>(std::floor(region.lo[k] / spacing_));
    bricks_[k] = static_cast<int>(std::ceil((region.hi[k] / spacing_ - lo_[k]) / brickCells)) + 1;
  }
  brick_.resize(std::size_t(bricks_[0]) * bricks_[1] * bricks_[2]);
}

void SampledWall::evaluate(Brick& brick, const int (&brickIndex)[3], const int (&cell)[3]) const {
  for (int c = 0; c < 8; ++c) {
    const int node[3] = {cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2)};
    float& value = brick.value[node[0] + brickNodes * (node[1] + brickNodes * node[2])];
    if (!std::isnan(value)) continue;
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = spacing_ * (lo_[k] + brickCells * brickIndex[k] + node[k]);
    value = static_cast<float>(wall_.distance(p).distance);
  }
}

WallDistance SampledWall::distance(const Vec3& p) const {
  const double nodesPerLength = 1.0 / spacing_;
  int brickIndex[3], cell[3];
  double t[3];
  for (int k = 0; k < 3; ++k) {
    const double u = p[k] * nodesPerLength - lo_[k];
    if (!(u >= 0.0 && u < double(bricks_[k]) * brickCells)) return wall_.distance(p);
    const int i = static_cast<int>(u);
    t[k] = u - i;
    brickIndex[k] = i / brickCells;
    cell[k] = i % brickCells;
  }
  std::unique_ptr<Brick>& slot =
      brick_[brickIndex[0] +
             std::size_t(bricks_[0]) * (brickIndex[1] + std::size_t(bricks_[1]) * brickIndex[2])];
  if (!slot) {
    slot = std::make_unique<Brick>();
    std::fill(std::begin(slot->value), std::end(slot->value), std::numeric_limits<float>::quiet_NaN());
  }
  const float* v = slot->value + cell[0] + brickNodes * (cell[1] + brickNodes * cell[2]);
  constexpr int row = brickNodes, plane = brickNodes * brickNodes;
  for (int again = 0;; ++again) {
    const double v000 = v[0], v100 = v[1], v010 = v[row], v110 = v[row + 1], v001 = v[plane],
                 v101 = v[plane + 1], v011 = v[plane + row], v111 = v[plane + row + 1];
    const double x00 = v000 + t[0] * (v100 - v000), x10 = v010 + t[0] * (v110 - v010);
    const double x01 = v001 + t[0] * (v101 - v001), x11 = v011 + t[0] * (v111 - v011);
    const double y0 = x00 + t[1] * (x10 - x00), y1 = x01 + t[1] * (x11 - x01);
    const double distance = y0 + t[2] * (y1 - y0);
    if (std::isnan(distance) && again == 0) {
      evaluate(*slot, brickIndex, cell);
      continue;
    }
    const double dx0 = (v100 - v000) + t[1] * ((v110 - v010) - (v100 - v000));
    const double dx1 = (v101 - v001) + t[1] * ((v111 - v011) - (v101 - v001));
    const Vec3 gradient(dx0 + t[2] * (dx1 - dx0), (x10 - x00) + t[2] * ((x11 - x01) - (x10 - x00)), y1 - y0);
    return {distance, nodesPerLength * gradient};
  }
}

}  // namespace packmesh
