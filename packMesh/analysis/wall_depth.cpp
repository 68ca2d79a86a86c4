// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/analysis/wall_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace packmesh {
namespace {

constexpr double nodesOfBox = 1 << 15;
constexpr double nearWall = 3.0;  ///< [spacings]

}  // namespace

WallDepth::WallDepth(const Wall& wall, const Box& box)
    : wall_(wall), box_(box), exact_(wall.closedForm().has_value()) {
  if (exact_) return;
  spacing_ = std::cbrt(box.size().prod() / nodesOfBox);
  std::size_t nodes = 1;
  for (int k = 0; k < 3; ++k) {
    cells_[k] = std::max(1, static_cast<int>(std::ceil(box.size()[k] / spacing_)));
    nodes *= cells_[k] + 1;
  }
  nodes_.assign(nodes, std::numeric_limits<double>::quiet_NaN());
}

double WallDepth::node(std::size_t index, int i, int j, int k) const {
  double& value = nodes_[index];
  if (std::isnan(value)) value = wall_.distance(box_.lo + spacing_ * Vec3(i, j, k)).distance;
  return value;
}

double WallDepth::operator()(const Vec3& p) const {
  if (exact_) return wall_.distance(p).distance;
  int at[3];
  double t[3];
  for (int k = 0; k < 3; ++k) {
    const double u = (p[k] - box_.lo[k]) / spacing_;
    at[k] = std::clamp(static_cast<int>(std::floor(u)), 0, cells_[k] - 1);
    t[k] = u - at[k];
  }
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1.0;
    int n[3];
    for (int k = 0; k < 3; ++k) {
      const int up = corner >> k & 1;
      n[k] = at[k] + up;
      weight *= up ? t[k] : 1.0 - t[k];
    }
    const std::size_t row = cells_[0] + 1, slab = row * (cells_[1] + 1);
    sum += weight * node(n[0] + row * n[1] + slab * n[2], n[0], n[1], n[2]);
  }
  return std::abs(sum) > nearWall * spacing_ ? sum : wall_.distance(p).distance;
}

}  // namespace packmesh
