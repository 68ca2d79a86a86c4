// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/field/sampled_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "packMesh/core/error.h"
#include "packMesh/core/vector.h"

namespace packmesh {
namespace {

/// The table of bricks then takes 1 GB.
constexpr double mostBricks = 1 << 28;

Vec3 firstBrick(const Box& region, double brick) {
  return (region.lo / brick).array().floor();
}

std::array<int, 3> bricksIn(const Box& region, double spacing) {
  const double brick = BrickView::cells * spacing;
  const Vec3 bricks = (region.hi / brick).array().floor() - firstBrick(region, brick).array() + 1.0;
  if (!(bricks.prod() <= mostBricks)) {
    const Vec3 size = region.size();
    throw InputError("distances in " + toText(size.x(), 3) + " x " + toText(size.y(), 3) + " x " +
                     toText(size.z(), 3) + " µm cannot be sampled at a spacing of " + toText(spacing, 3) +
                     " µm; at most " + toText(mostBricks * brick * brick * brick, 2) + " µm³ are supported");
  }
  return {static_cast<int>(bricks[0]), static_cast<int>(bricks[1]), static_cast<int>(bricks[2])};
}

}  // namespace

SampledDistance::SampledDistance(const DistanceSource& source, const Box& region, double spacing)
    : source_(source),
      spacing_(spacing),
      lo_(BrickView::cells * firstBrick(region, BrickView::cells * spacing)),
      bricks_(bricksIn(region, spacing)) {}

const std::int16_t* SampledDistance::brick(int index) const try {
  return bricks_.at(index, [&](std::int16_t* values) {
    const int(&count)[3] = bricks_.count();
    const int at[3] = {index % count[0], index / count[0] % count[1], index / count[0] / count[1]};
    NodeBlock block;
    block.spacing = spacing_;
    for (int k = 0; k < 3; ++k) {
      block.origin[k] = spacing_ * (lo_[k] + BrickView::cells * at[k]);
      block.nodes[k] = BrickView::row;
    }
    std::array<float, BrickView::nodes> distances;
    source_.sample(block, distances.data());
    const float steps = static_cast<float>(BrickView::stepsPerSpacing / spacing_);
    for (int n = 0; n < BrickView::nodes; ++n) {
      constexpr float furthest = std::numeric_limits<std::int16_t>::max();
      const float stored = std::clamp(steps * distances[n], -furthest, furthest);
      values[n] = static_cast<std::int16_t>(stored + (stored < 0.0f ? -0.5f : 0.5f));
    }
    return true;
  });
} catch (const std::length_error&) {
  throw InputError("the distances to the walls near cells need more than 4 GB at a spacing of " +
                   toText(spacing_, 3) + " µm");
}

BrickView SampledDistance::view() const {
  const int(&count)[3] = bricks_.count();
  return {bricks_.begins(),
          bricks_.values(),
          {count[0], count[1], count[2]},
          static_cast<float>(1.0 / spacing_),
          this,
          [](const SampledDistance& sampled, int index) { sampled.brick(index); }};
}

/// A point in its cell, and what is interpolated there.
struct SampledDistance::Place {
  GridCell cell;
  Trilinear<double> at;

  Place(const SampledDistance& field, const Vec3& p)
      : cell(cellOf(field, p)), at(interpolated(field, cell)) {}

  double distance(double spacing) const {
    return spacing / BrickView::stepsPerSpacing * at.value - spacing * cell.beyond.cwiseAbs().sum();
  }

 private:
  static GridCell cellOf(const SampledDistance& field, const Vec3& p) {
    const int(&count)[3] = field.bricks_.count();
    return GridCell(field.nodeOf(p),
                    {BrickView::cells * count[0], BrickView::cells * count[1], BrickView::cells * count[2]});
  }
  static Trilinear<double> interpolated(const SampledDistance& field, const GridCell& cell) {
    const std::int16_t* low =
        field.brick(BrickView::brickOf(cell.node, field.bricks_.count())) + BrickView::placeOf(cell.node);
    return cell.interpolate(BrickView::row, BrickView::slab, [&](std::size_t n) { return low[n]; });
  }
};

double SampledDistance::distance(const Vec3& p) const {
  return Place(*this, p).distance(spacing_);
}

DistanceSample SampledDistance::sample(const Vec3& p) const {
  const Place place(*this, p);
  const GridCell& cell = place.cell;
  const Trilinear<double>& at = place.at;
  DistanceSample result;
  result.distance = place.distance(spacing_);
  result.gradient = Vec3(at.slope) / BrickView::stepsPerSpacing;
  for (int k = 0; k < 3; ++k)
    if (cell.beyond[k] != 0.0) result.gradient[k] = cell.beyond[k] < 0.0 ? 1.0 : -1.0;
  return result;
}

}  // namespace packmesh
