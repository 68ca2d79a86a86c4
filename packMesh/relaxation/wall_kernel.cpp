// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/contact_kernels.h"

#include "packMesh/field/interpolation.h"
#include "packMesh/simd/lanes.h"

namespace packmesh {
namespace {

constexpr int width = laneCount;

struct Point {
  Lanes x, y, z;
};

/// Points of the cell relative to its centre, along the axes of the world.
inline Point pointsOf(const WallFrame& f, const Lanes& x, const Lanes& y, const Lanes& z) {
  return {f.m[0] * x + f.m[1] * y + f.m[2] * z, f.m[3] * x + f.m[4] * y + f.m[5] * z,
          f.m[6] * x + f.m[7] * y + f.m[8] * z};
}

struct Look {
  Lanes distance;
  Point gradient;
};

/// Combines with the plane at distance `apart` along `axis`, with the lumen towards `sign`, where that one is
/// nearer.
inline void consider(Look& look, const Lanes& apart, int axis, float sign) {
  const Mask nearer = apart < look.distance;
  look.distance = smaller(look.distance, apart);
  look.gradient.x = select(nearer, splat(axis == 0 ? sign : 0.0f), look.gradient.x);
  look.gradient.y = select(nearer, splat(axis == 1 ? sign : 0.0f), look.gradient.y);
  look.gradient.z = select(nearer, splat(axis == 2 ? sign : 0.0f), look.gradient.z);
}

inline Look closedForm(const WallForm& wall, const Point& p) {
  Look look{splat(WallForm::none), {splat(0.0f), splat(0.0f), splat(0.0f)}};
  if (wall.radius > 0.0f) {
    const Lanes x = wall.across[0] * p.x, y = wall.across[1] * p.y, z = wall.across[2] * p.z;
    const Point q{x + wall.fromAxis[0], y + wall.fromAxis[1], z + wall.fromAxis[2]};
    const Lanes r = squareRoot(q.x * q.x + q.y * q.y + q.z * q.z);
    const Lanes excess = wall.excess -
                         2.0f * (wall.fromAxis[0] * x + wall.fromAxis[1] * y + wall.fromAxis[2] * z) -
                         (x * x + y * y + z * z);
    look.distance = excess / (r + wall.radius);
    const Lanes inward = splat(-1.0f) / larger(r, splat(1e-6f));  // finite in the centre
    look.gradient = {inward * q.x, inward * q.y, inward * q.z};
  }
  const Lanes* along[3] = {&p.x, &p.y, &p.z};
  for (int k = 0; k < 3; ++k) {
    if (wall.toLo[k] < WallForm::none) consider(look, wall.toLo[k] + *along[k], k, 1.0f);
    if (wall.toHi[k] < WallForm::none) consider(look, wall.toHi[k] - *along[k], k, -1.0f);
  }
  return look;
}

/// Interpolates; outside the grid, the value at the nearest point of it minus the distance to that point.
inline Look sampled(const WallGrid& grid, const Point& p) {
  const BrickView& bricks = grid.bricks;
  const Lanes* along[3] = {&p.x, &p.y, &p.z};
  Lanes beyond[3], t[3];
  Ints node[3];
  for (int k = 0; k < 3; ++k) {
    const Lanes u = bricks.nodesPerLength * *along[k] + grid.start[k];
    const Lanes inside = smaller(larger(u, splat(grid.first[k])), splat(grid.last[k]));
    beyond[k] = u - inside;
    const Ints whole = truncated(inside);
    t[k] = inside - toFloat(whole);
    node[k] = whole + grid.base[k];
  }
  const Ints index = BrickView::brickOf(node, bricks.bricks);
  Ints begin = gatherAcquire(bricks.begins, index);
  if (const unsigned unknown = bitsOf(begin < 0)) {
    for (int lane = 0; lane < width; ++lane)
      if (unknown >> lane & 1u) bricks.evaluate(*bricks.sampled, laneOf(index, lane));
    begin = gatherAcquire(bricks.begins, index);
  }
  const Ints first = begin + BrickView::placeOf(node);
  const std::int16_t* values = __atomic_load_n(bricks.values, __ATOMIC_RELAXED);
  Lanes c[8];
  for (int k = 0; k < 4; ++k) {  // two neighbours along x at a time
    const Ints both = gather(values, first + ((k & 1) * BrickView::row + (k >> 1) * BrickView::slab));
    c[2 * k] = toFloat(both << 16 >> 16);
    c[2 * k + 1] = toFloat(both >> 16);
  }
  const Trilinear<Lanes> at(c, t);
  constexpr float perStep = 1.0f / BrickView::stepsPerSpacing;
  Look look;
  look.distance = perStep * at.value;
  Lanes* gradient[3] = {&look.gradient.x, &look.gradient.y, &look.gradient.z};
  for (int k = 0; k < 3; ++k) {
    look.distance = look.distance - magnitude(beyond[k]);
    const Lanes inside = select(splat(0.0f) < beyond[k], splat(-1.0f), perStep * at.slope[k]);
    *gradient[k] = select(beyond[k] < splat(0.0f), splat(1.0f), inside);
  }
  look.distance = look.distance / splat(bricks.nodesPerLength);
  return look;
}

/// Distance and gradient at points, exact only where the distance is below `limit`.
inline Look look(const WallFrame& frame, const Point& p, float limit) {
  if (frame.kind == WallFrame::Kind::form) return closedForm(frame.form, p);
  if (frame.kind == WallFrame::Kind::coarse) return sampled(frame.coarse, p);
  const Lanes atLeast = sampled(frame.coarse, p).distance - frame.slack;
  const Mask close = atLeast < splat(limit);
  const unsigned lanes = bitsOf(close);
  if (lanes == 0) return {atLeast, {splat(0.0f), splat(0.0f), splat(0.0f)}};
  // Bricks are only computed where they are needed: lanes whose point is far away use another point.
  const int lane = __builtin_ctz(lanes);
  const Point near{select(close, p.x, splat(laneOf(p.x, lane))), select(close, p.y, splat(laneOf(p.y, lane))),
                   select(close, p.z, splat(laneOf(p.z, lane)))};
  Look fine = sampled(frame.fine, near);
  fine.distance = select(close, fine.distance, atLeast);
  return fine;
}

/// Adds a contact to the one with a similar direction, or as a new one.
inline void add(WallSums& out, const WallContact& found) {
  constexpr float alike = 0.7f;  // cosine
  int slot = 0;
  for (; slot < out.contacts; ++slot) {
    const WallContact& c = out.contact[slot];
    const float along =
        c.normal[0] * found.normal[0] + c.normal[1] * found.normal[1] + c.normal[2] * found.normal[2];
    if (along >= alike * c.weight * found.weight) break;
  }
  if (slot == WallSums::most) --slot;
  WallContact& c = out.contact[slot];
  if (slot == out.contacts) {
    c = found;
    ++out.contacts;
    return;
  }
  c.weight += found.weight;
  for (int k = 0; k < 3; ++k) {
    c.point[k] += found.point[k];
    c.normal[k] += found.normal[k];
  }
  c.deepest = c.deepest > found.deepest ? c.deepest : found.deepest;
}

/// Adds the points of a cluster: as one contact where they touch the wall from one side, otherwise one by
/// one.
inline void add(WallSums& out, const Lanes& penetration, const Point& p, const Point& gradient) {
  constexpr float together = 0.9f;
  float points[4], normals[4];
  sums(penetration, penetration * p.x, penetration * p.y, penetration * p.z, points);
  sums(penetration, penetration * gradient.x, penetration * gradient.y, penetration * gradient.z, normals);
  const WallContact all{points[0],
                        {points[1], points[2], points[3]},
                        {normals[1], normals[2], normals[3]},
                        largest(penetration)};
  const float squared =
      all.normal[0] * all.normal[0] + all.normal[1] * all.normal[1] + all.normal[2] * all.normal[2];
  if (squared >= together * together * all.weight * all.weight) {
    add(out, all);
    return;
  }
  float depth[width], x[width], y[width], z[width], gx[width], gy[width], gz[width];
  store(penetration, depth);
  store(p.x, x), store(p.y, y), store(p.z, z);
  store(gradient.x, gx), store(gradient.y, gy), store(gradient.z, gz);
  for (int k = 0; k < width; ++k) {
    const float d = depth[k];
    if (d > 0.0f) add(out, {d, {d * x[k], d * y[k], d * z[k]}, {d * gx[k], d * gy[k], d * gz[k]}, d});
  }
}

void wall(const SampleView& samples, const WallFrame& frame, float clearance, float margin, ClusterMask& mask,
          WallSums& out) {
  const bool everywhere = mask == allClusters;
  const float limit = everywhere ? clearance + margin : clearance;
  ClusterMask near = 0;
  Lanes nearest = splat(WallForm::none);
  out.contacts = 0;
  for (int group = 0; group < samples.clusters; group += width) {
    const int count = samples.clusters - group < width ? samples.clusters - group : width;
    unsigned members = 0;
    if (everywhere) {
      const Point center = pointsOf(frame, load(samples.centerX + group), load(samples.centerY + group),
                                    load(samples.centerZ + group));
      const Lanes distance = frame.kind == WallFrame::Kind::form ? closedForm(frame.form, center).distance
                                                                 : sampled(frame.coarse, center).distance;
      const Lanes apart = distance - frame.slack - frame.scale * load(samples.radius + group);
      const Mask close = apart < splat(limit);
      nearest = smaller(nearest, select(close, nearest, apart));
      members = bitsOf(close) & ((1u << count) - 1u);
    } else if (samples.bitShift == 0) {
      members = static_cast<unsigned>(mask >> group) & ((1u << count) - 1u);
    } else {
      for (int k = 0; k < count; ++k)
        members |= static_cast<unsigned>(mask >> ((group + k) >> samples.bitShift) & 1u) << k;
    }
    for (; members != 0; members &= members - 1) {
      const int cluster = group + __builtin_ctz(members), first = cluster * width;
      const Point p =
          pointsOf(frame, load(samples.x + first), load(samples.y + first), load(samples.z + first));
      const Look at = look(frame, p, limit);
      nearest = smaller(nearest, at.distance);
      if (bitsWhereLess(at.distance, splat(limit)) == 0) continue;
      near |= ClusterMask{1} << (cluster >> samples.bitShift);
      const Lanes penetration = larger(clearance - at.distance, splat(0.0f));
      if (bitsWhereLess(splat(0.0f), penetration) != 0) add(out, penetration, p, at.gradient);
    }
  }
  if (everywhere) mask = near;
  out.nearest = smallest(nearest);
}

}  // namespace

template <InstructionSet set>
WallKernel wallKernel() {
  return wall;
}
template WallKernel wallKernel<InstructionSet::PACKMESH_INSTRUCTION_SET>();

}  // namespace packmesh
