// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/wall_field.h"

#include <algorithm>
#include <cmath>

namespace packmesh {
namespace {

/// Interpolated distances to an edge or corner, the sharpest feature of a wall, are too large by at most this
/// [spacings] (measured); to smoother walls by less.
constexpr double interpolationExcess = 0.26;

WallGrid gridOf(const SampledDistance& wall, const Vec3& center, double reach) {
  WallGrid grid;
  grid.bricks = wall.view();
  const Vec3 at = wall.nodeOf(center);
  const int below = static_cast<int>(reach / wall.spacing()) + 2;
  for (int k = 0; k < 3; ++k) {
    const int cells = BrickView::cells * grid.bricks.bricks[k];
    grid.base[k] = static_cast<int>(std::min(std::floor(at[k]) - below, cells - 1.0));
    grid.start[k] = static_cast<float>(at[k] - grid.base[k]);
    grid.first[k] = static_cast<float>(std::max(0, -grid.base[k]));
    // Slightly less, so that a node remains above.
    grid.last[k] = std::nextafter(static_cast<float>(cells - grid.base[k]), 0.0f);
  }
  return grid;
}

float orNone(double distance) {
  return static_cast<float>(std::min<double>(distance, WallForm::none));
}

WallForm formOf(const ClosedFormWall& wall, const Vec3& center) {
  WallForm form;
  const Vec3 fromAxis = wall.across.cwiseProduct(center - wall.center);
  form.radius = static_cast<float>(wall.radius);
  form.excess = static_cast<float>(wall.radius * wall.radius - fromAxis.squaredNorm());
  for (int k = 0; k < 3; ++k) {
    form.across[k] = static_cast<float>(wall.across[k]);
    form.fromAxis[k] = static_cast<float>(fromAxis[k]);
    form.toLo[k] = orNone(center[k] - wall.lo[k]);
    form.toHi[k] = orNone(wall.hi[k] - center[k]);
  }
  return form;
}

}  // namespace

WallField::WallField(const Wall& wall, const Box& region) : form_(wall.closedForm()) {
  if (form_) return;
  sampled_.emplace(Sampled{wall.coarselySampled(region), wall.sampled(region)});
  slack_ = wall.slack() + interpolationExcess * sampled_->coarse.spacing();
}

double WallField::distance(const Vec3& p) const {
  return form_ ? form_->distance(p).distance : sampled_->coarse.sample(p).distance;
}

WallFrame WallField::frameOf(const Body& body, double reach, bool deep) const {
  WallFrame frame{};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) frame.m[3 * r + c] = static_cast<float>(body.scale * body.rotation(r, c));
  frame.scale = static_cast<float>(body.scale);
  frame.slack = static_cast<float>(slack_);
  if (form_) {
    frame.kind = WallFrame::Kind::form;
    frame.form = formOf(*form_, body.position);
    return frame;
  }
  frame.kind = deep ? WallFrame::Kind::coarse : WallFrame::Kind::sampled;
  frame.coarse = gridOf(sampled_->coarse, body.position, reach);
  if (!deep) frame.fine = gridOf(sampled_->fine, body.position, reach);
  return frame;
}

}  // namespace packmesh
