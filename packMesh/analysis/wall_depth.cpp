// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/analysis/wall_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "packMesh/field/grid_cell.h"

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
  nodes_ = std::vector<std::atomic<double>>(nodes);
  for (std::atomic<double>& node : nodes_) node = std::numeric_limits<double>::quiet_NaN();
}

double WallDepth::node(std::size_t index) const {
  if (const double known = nodes_[index].load(std::memory_order_relaxed); !std::isnan(known)) return known;
  const std::size_t row = cells_[0] + 1, slab = row * (cells_[1] + 1);
  const Vec3 at(double(index % row), double(index % slab / row), double(index / slab));
  const double value = wall_.distance(box_.lo + spacing_ * at).distance;
  nodes_[index].store(value, std::memory_order_relaxed);
  return value;
}

double WallDepth::operator()(const Vec3& p) const {
  if (exact_) return wall_.distance(p).distance;
  const GridCell cell((p - box_.lo) / spacing_, cells_);
  const std::size_t row = cells_[0] + 1, slab = row * (cells_[1] + 1);
  const std::size_t low = cell.node[0] + row * cell.node[1] + slab * cell.node[2];
  const double depth = cell.interpolate(row, slab, [&](std::size_t n) { return node(low + n); }).value;
  return std::abs(depth) > nearWall * spacing_ ? depth : wall_.distance(p).distance;
}

}  // namespace packmesh
