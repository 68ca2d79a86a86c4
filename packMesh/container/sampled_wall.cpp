// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/sampled_wall.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "packMesh/core/error.h"
#include "packMesh/core/vector_text.h"

namespace packmesh {
namespace {

/// Their table takes 1 GB.
constexpr double mostBricks = 1 << 28;

}  // namespace

SampledWall::SampledWall(const Wall& wall, const Box& region, double spacing)
    : wall_(wall), spacing_(spacing) {
  const double brick = BrickView::cells * spacing;
  const Vec3 first = (region.lo / brick).array().floor();
  const Vec3 bricks = (region.hi / brick).array().floor() - first.array() + 1.0;
  if (!(bricks.prod() <= mostBricks)) {
    const Vec3 size = region.size();
    throw InputError("walls in " + toText(size.x(), 3) + " x " + toText(size.y(), 3) + " x " +
                     toText(size.z(), 3) + " µm are too much to sample at a spacing of " +
                     toText(spacing, 3) + " µm; at most " + toText(mostBricks * brick * brick * brick, 2) +
                     " µm³ are possible");
  }
  lo_ = BrickView::cells * first;
  for (int k = 0; k < 3; ++k) bricks_[k] = static_cast<int>(bricks[k]);
  begins_.assign(static_cast<std::size_t>(bricks.prod()), -1);
}

void SampledWall::evaluate(int index) const {
  if (begins_[index] >= 0) return;
  const int brick[3] = {index % bricks_[0], index / bricks_[0] % bricks_[1], index / bricks_[0] / bricks_[1]};
  NodeBlock block;
  block.spacing = spacing_;
  for (int k = 0; k < 3; ++k) {
    block.origin[k] = spacing_ * (lo_[k] + BrickView::cells * brick[k]);
    block.nodes[k] = BrickView::row;
  }
  std::array<float, BrickView::nodes> distances;
  wall_.sample(block, distances.data());
  constexpr std::size_t most = std::numeric_limits<std::int32_t>::max() - BrickView::nodes;
  if (values_.size() > most)
    throw InputError("the walls near cells need more than 4 GB at a spacing of " + toText(spacing_, 3) +
                     " µm");
  const std::size_t begin = values_.empty() ? 0 : values_.size() - 1;
  values_.resize(begin + BrickView::nodes + 1);
  where_ = values_.data();
  const float steps = static_cast<float>(BrickView::stepsPerSpacing / spacing_);
  for (int n = 0; n < BrickView::nodes; ++n) {
    constexpr float furthest = std::numeric_limits<std::int16_t>::max();
    const float stored = std::clamp(steps * distances[n], -furthest, furthest);
    values_[begin + n] = static_cast<std::int16_t>(stored + (stored < 0.0f ? -0.5f : 0.5f));
  }
  begins_[index] = static_cast<std::int32_t>(begin);
}

BrickView SampledWall::view() const {
  return {begins_.data(),
          &where_,
          {bricks_[0], bricks_[1], bricks_[2]},
          static_cast<float>(1.0 / spacing_),
          this,
          [](const SampledWall& wall, int index) { wall.evaluate(index); }};
}

WallDistance SampledWall::distance(const Vec3& p) const {
  const Vec3 u = nodeOf(p);
  int brick[3], cell[3];
  double t[3];
  Vec3 beyond;  // from the region [nodes]
  for (int k = 0; k < 3; ++k) {
    const int cells = bricks_[k] * BrickView::cells;
    const double inside = std::clamp(u[k], 0.0, static_cast<double>(cells));
    const int i = std::min(static_cast<int>(inside), cells - 1);
    beyond[k] = u[k] - inside;
    t[k] = inside - i;
    brick[k] = i / BrickView::cells;
    cell[k] = i % BrickView::cells;
  }
  const int index = brick[0] + bricks_[0] * (brick[1] + bricks_[1] * brick[2]);
  evaluate(index);
  constexpr int row = BrickView::row, slab = BrickView::slab;
  const std::int16_t* v = where_ + begins_[index] + cell[0] + row * cell[1] + slab * cell[2];
  const double v000 = v[0], v100 = v[1], v010 = v[row], v110 = v[row + 1], v001 = v[slab], v101 = v[slab + 1],
               v011 = v[slab + row], v111 = v[slab + row + 1];
  const double x00 = v000 + t[0] * (v100 - v000), x10 = v010 + t[0] * (v110 - v010);
  const double x01 = v001 + t[0] * (v101 - v001), x11 = v011 + t[0] * (v111 - v011);
  const double y0 = x00 + t[1] * (x10 - x00), y1 = x01 + t[1] * (x11 - x01);
  const double dx0 = (v100 - v000) + t[1] * ((v110 - v010) - (v100 - v000));
  const double dx1 = (v101 - v001) + t[1] * ((v111 - v011) - (v101 - v001));
  WallDistance result;
  const double perStep = spacing_ / BrickView::stepsPerSpacing;
  result.distance = perStep * (y0 + t[2] * (y1 - y0)) - spacing_ * beyond.lpNorm<1>();
  result.gradient = Vec3(dx0 + t[2] * (dx1 - dx0), (x10 - x00) + t[2] * ((x11 - x01) - (x10 - x00)), y1 - y0);
  result.gradient /= BrickView::stepsPerSpacing;
  for (int k = 0; k < 3; ++k)
    if (beyond[k] != 0.0) result.gradient[k] = beyond[k] < 0.0 ? 1.0 : -1.0;
  return result;
}

}  // namespace packmesh
