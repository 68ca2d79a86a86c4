// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Body of the contact kernel; included by one translation unit per instruction set, which defines
/// PACKMESH_KERNEL_NAMESPACE. See contact_kernel.h.

#include "packMesh/geometry/lanes.h"
#include "packMesh/stages/relaxation/contact_kernel.h"

namespace packmesh {
namespace PACKMESH_KERNEL_NAMESPACE {
namespace {

constexpr int width = laneCount;

struct Point {
  Lanes x, y, z;
};

inline Point transform(const RelativeFrame& f, Lanes x, Lanes y, Lanes z) {
  return {f.m[0] * x + f.m[1] * y + f.m[2] * z + f.t[0], f.m[3] * x + f.m[4] * y + f.m[5] * z + f.t[1],
          f.m[6] * x + f.m[7] * y + f.m[8] * z + f.t[2]};
}

/// A distance that the surface certainly has from points around `p`: from the disc + ellipsoid and the box.
inline Lanes lowerBound(const FieldView& field, const Point& p) {
  const Lanes rho = squareRoot(p.x * p.x + p.z * p.z);
  const Lanes beyond = larger(rho - field.ring, splat(0.0f));
  const Lanes rounded = squareRoot(beyond * beyond + p.y * p.y) - field.thickness;
  const Lanes flat = larger(magnitude(p.y) - field.extent[1],
                            larger(magnitude(p.x) - field.extent[0], magnitude(p.z) - field.extent[2]));
  return larger(rounded, flat);
}

/// Value F and gradient of a function that vanishes on the surface, with |gradient|²/4; distance() of it is
/// the distance to the surface.
struct Level {
  Lanes f;
  Point gradient;
  Lanes quarter;
};

inline Lanes quarterOf(const Point& g) {
  return 0.25f * (g.x * g.x + g.y * g.y + g.z * g.z);
}

/// F = y² - P(s), P continued beyond the rim s = 1 by a parabola: the polynomial itself says nothing there, a
/// red cell's returns to zero at 1.36 radii.
inline Level closedForm(const FieldView& field, const Point& q) {
  const Lanes s = field.a * q.x * q.x + field.c * q.z * q.z;
  const Lanes inner = smaller(s, splat(1.0f)), beyond = s - inner, bend = field.bend * beyond;
  Lanes value = splat(field.p[5]), slope = splat(5.0f * field.p[5]);
  for (int k = 4; k >= 0; --k) value = value * inner + field.p[k];
  for (int k = 4; k >= 1; --k) slope = slope * inner + static_cast<float>(k) * field.p[k];
  value += (slope + bend) * beyond;
  slope += 2.0f * bend;
  Level level;
  level.f = q.y * q.y - value;
  const Lanes radial = -2.0f * slope;
  level.gradient = {radial * field.a * q.x, 2.0f * q.y, radial * field.c * q.z};
  level.quarter = quarterOf(level.gradient);
  return level;
}

/// d = F / (|grad F|/2 + sqrt(|grad F|²/4 - F)), the smaller root of d² - |grad F| d + F = 0: exact for
/// spheres, within 0.0006 µm of the distance near the surface of a red cell; between F / |grad F| and twice
/// that.
inline Lanes closedFormDistance(const Level& level) {
  const Lanes denominator =
      squareRoot(level.quarter) + squareRoot(larger(level.quarter - level.f, splat(0.0f)));
  return level.f / larger(denominator, splat(1e-6f));
}

/// F = the sampled distance, by trilinear interpolation; outside the grid, where points are further away than
/// any clearance, a bound of it: the cell lies on the other side of the nearest point of the grid.
inline Level sampled(const FieldView& field, const Point& q) {
  Lanes u[3] = {field.nodesPerLength * (q.x - field.origin[0]),
                field.nodesPerLength * (q.y - field.origin[1]),
                field.nodesPerLength * (q.z - field.origin[2])};
  Lanes outside = splat(0.0f);
  float at[3][width];
  for (int k = 0; k < 3; ++k) {
    const Lanes inside =
        smaller(larger(u[k], splat(0.0f)), splat(static_cast<float>(field.nodes[k]) - 1.0001f));
    outside = larger(outside, magnitude(u[k] - inside));
    store(inside, at[k]);
  }
  const int row = field.nodes[0], slab = field.nodes[0] * field.nodes[1];
  float corner[8][width], fraction[3][width];
  for (int lane = 0; lane < width; ++lane) {
    int node[3];
    for (int k = 0; k < 3; ++k) {
      node[k] = static_cast<int>(at[k][lane]);
      fraction[k][lane] = at[k][lane] - static_cast<float>(node[k]);
    }
    const float* v = field.value + node[0] + row * node[1] + slab * node[2];
    corner[0][lane] = v[0];
    corner[1][lane] = v[1];
    corner[2][lane] = v[row];
    corner[3][lane] = v[row + 1];
    corner[4][lane] = v[slab];
    corner[5][lane] = v[slab + 1];
    corner[6][lane] = v[slab + row];
    corner[7][lane] = v[slab + row + 1];
  }
  const Lanes t[3] = {load(fraction[0]), load(fraction[1]), load(fraction[2])};
  Lanes c[8];
  for (int k = 0; k < 8; ++k) c[k] = load(corner[k]);
  const auto mix = [](const Lanes& a, const Lanes& b, const Lanes& w) { return a + (b - a) * w; };
  const Lanes y00 = mix(c[0], c[1], t[0]), y10 = mix(c[2], c[3], t[0]);
  const Lanes y01 = mix(c[4], c[5], t[0]), y11 = mix(c[6], c[7], t[0]);
  const Lanes z0 = mix(y00, y10, t[1]), z1 = mix(y01, y11, t[1]);
  Level level;
  level.f = mix(z0, z1, t[2]);
  level.f = select(splat(0.0f) < outside, larger(level.f, outside / splat(field.nodesPerLength)), level.f);
  level.gradient.x = mix(mix(c[1] - c[0], c[3] - c[2], t[1]), mix(c[5] - c[4], c[7] - c[6], t[1]), t[2]);
  level.gradient.y = mix(y10 - y00, y11 - y01, t[2]);
  level.gradient.z = z1 - z0;
  level.quarter = quarterOf(level.gradient);
  return level;
}

}  // namespace

void contact(const SampleView& samples, const RelativeFrame& frame, const FieldView& field, float clearance,
             float margin, ClusterMask& mask, ContactSums& out) {
  const bool everywhere = mask == allClusters;
  const float limit = everywhere ? clearance + margin : clearance;
  ClusterMask near = 0;
  Lanes weight = splat(0.0f), px = weight, py = weight, pz = weight, nx = weight, ny = weight, nz = weight,
        deepest = weight;
  Lanes nearest = splat(1e30f);
  bool touching = false;
  for (int group = 0; group < samples.clusters; group += width) {
    const int count = samples.clusters - group < width ? samples.clusters - group : width;
    unsigned members = 0;
    if (everywhere) {
      const Point center = transform(frame, load(samples.centerX + group), load(samples.centerY + group),
                                     load(samples.centerZ + group));
      const Lanes apart = lowerBound(field, center) - frame.scale * load(samples.radius + group);
      const Mask close = apart < splat(limit);
      nearest = smaller(nearest, select(close, nearest, apart));
      members = bitsOf(close) & ((1u << count) - 1u);
    } else if (samples.clustersPerBit == 1) {
      members = static_cast<unsigned>(mask >> group) & ((1u << count) - 1u);
    } else {
      for (int k = 0; k < count; ++k)
        members |= static_cast<unsigned>(mask >> ((group + k) / samples.clustersPerBit) & 1u) << k;
    }
    for (; members != 0; members &= members - 1) {
      const int cluster = group + __builtin_ctz(members);
      const int first = cluster * width;
      const Point q =
          transform(frame, load(samples.x + first), load(samples.y + first), load(samples.z + first));
      const Level level = field.onGrid ? sampled(field, q) : closedForm(field, q);
      if (!field.onGrid) {
        // Can any point be nearer than the limit? F / |grad F| is no more than the distance where F is
        // convex, thus around any ellipsoid, and around red cells too.
        const Mask within =
            (level.f < splat(0.0f)) | (level.f * level.f < (4.0f * limit * limit) * level.quarter);
        if (bitsOf(within) == 0) {
          nearest = smaller(nearest, splat(limit));
          continue;
        }
      }
      near |= ClusterMask{1} << cluster / samples.clustersPerBit;
      const Lanes distance = field.onGrid ? level.f : closedFormDistance(level);
      const Lanes penetration = larger(clearance - distance, splat(0.0f));
      const Lanes slope = larger(2.0f * squareRoot(level.quarter), splat(1e-6f));
      if (bitsOf(splat(0.0f) < penetration) == 0) {
        if (!touching) nearest = smaller(nearest, field.onGrid ? distance : level.f / slope);
        continue;
      }
      touching = true;
      const Lanes perLength = penetration / slope;
      weight += penetration;
      px += penetration * q.x;
      py += penetration * q.y;
      pz += penetration * q.z;
      nx += perLength * level.gradient.x;
      ny += perLength * level.gradient.y;
      nz += perLength * level.gradient.z;
      deepest = larger(deepest, penetration);
    }
  }
  if (everywhere) mask = near;
  out.weight = 0.0f;
  if (!touching) {
    out.nearest = smallest(nearest);
    return;
  }
  out.weight = sum(weight);
  out.point[0] = sum(px);
  out.point[1] = sum(py);
  out.point[2] = sum(pz);
  out.normal[0] = sum(nx);
  out.normal[1] = sum(ny);
  out.normal[2] = sum(nz);
  out.deepest = largest(deepest);
  out.nearest = clearance - out.deepest;
}

}  // namespace PACKMESH_KERNEL_NAMESPACE
}  // namespace packmesh
