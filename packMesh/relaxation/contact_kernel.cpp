// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/contact_kernel.h"

#include "packMesh/field/trilinear.h"
#include "packMesh/simd/lanes.h"

namespace packmesh {
namespace {

constexpr int width = laneCount;

struct Point {
  Lanes x, y, z;
};

inline Point transform(const RelativeFrame& f, Lanes x, Lanes y, Lanes z) {
  return {f.m[0] * x + f.m[1] * y + f.m[2] * z + f.t[0], f.m[3] * x + f.m[4] * y + f.m[5] * z + f.t[1],
          f.m[6] * x + f.m[7] * y + f.m[8] * z + f.t[2]};
}

/// Lower bound of the distance between the surface and the points around `p`, from the disc + ellipsoid bound
/// and the box.
inline Lanes lowerBound(const FieldView& field, const Point& p) {
  const Lanes rho = squareRoot(p.x * p.x + p.z * p.z);
  const Lanes beyond = larger(rho - field.ring, splat(0.0f));
  const Lanes rounded = squareRoot(beyond * beyond + p.y * p.y) - field.thickness;
  const Lanes flat = larger(magnitude(p.y) - field.extent[1],
                            larger(magnitude(p.x) - field.extent[0], magnitude(p.z) - field.extent[2]));
  return larger(rounded, flat);
}

/// Value F and gradient of a function that vanishes on the surface, with |gradient|²/4; distance() converts
/// it to the distance to the surface.
struct Level {
  Lanes f;
  Point gradient;
  Lanes quarter;
};

inline Lanes quarterOf(const Point& g) {
  return 0.25f * (g.x * g.x + g.y * g.y + g.z * g.z);
}

/// F = y² - P(s), with P continued beyond the rim s = 1 by a parabola: the polynomial itself is meaningless
/// there; a red cell's returns to zero at 1.36 radii.
inline Level closedForm(const FieldView& field, const Point& q) {
  const Lanes s = field.a * q.x * q.x + field.c * q.z * q.z;
  const Lanes inner = smaller(s, splat(1.0f)), beyond = s - inner, bend = field.bend * beyond;
  const float* p = field.p;
  const Lanes square = inner * inner;  // Estrin's order: shorter chains than Horner's
  Lanes value = (p[0] + p[1] * inner) + square * ((p[2] + p[3] * inner) + square * (p[4] + p[5] * inner));
  Lanes slope =
      (p[1] + 2.0f * p[2] * inner) + square * ((3.0f * p[3] + 4.0f * p[4] * inner) + square * (5.0f * p[5]));
  value += (slope + bend) * beyond;
  slope += 2.0f * bend;
  Level level;
  level.f = q.y * q.y - value;
  const Lanes radial = -2.0f * slope;
  level.gradient = {radial * field.a * q.x, 2.0f * q.y, radial * field.c * q.z};
  level.quarter = quarterOf(level.gradient);
  return level;
}

/// F = the sampled distance, by trilinear interpolation. Outside the grid, where points are further away than
/// any clearance, a lower bound: the cell lies on the other side of the nearest point of the grid.
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
  const Trilinear<Lanes> interpolated(c, t);
  Level level;
  level.f = interpolated.value;
  level.f = select(splat(0.0f) < outside, larger(level.f, outside / splat(field.nodesPerLength)), level.f);
  level.gradient = {interpolated.slope[0], interpolated.slope[1], interpolated.slope[2]};
  level.quarter = quarterOf(level.gradient);
  return level;
}

/// What the first pass over a cluster passes on to the second.
struct NearCluster {
  Point q;
  Level level;
};

/// Number of clusters processed together: one 64-bit word.
constexpr int chunk = 64;

/// Running sums of ContactSums, one per lane.
struct LaneSums {
  Lanes weight = splat(0.0f), px = weight, py = weight, pz = weight, nx = weight, ny = weight, nz = weight,
        gradient = weight, deepest = weight;

  void add(const NearCluster& cluster, const Lanes& penetration, const Lanes& length) {
    const Point &q = cluster.q, &g = cluster.level.gradient;
    weight += penetration;
    px += penetration * q.x;
    py += penetration * q.y;
    pz += penetration * q.z;
    nx += penetration * g.x;
    ny += penetration * g.y;
    nz += penetration * g.z;
    gradient += penetration * length;
    deepest = larger(deepest, penetration);
  }

  void store(ContactSums& out) const {
    float v[4];
    sums(weight, px, py, pz, v);
    out.weight = v[0];
    for (int k = 0; k < 3; ++k) out.point[k] = v[k + 1];
    sums(gradient, nx, ny, nz, v);
    out.gradient = v[0];
    for (int k = 0; k < 3; ++k) out.normal[k] = v[k + 1];
    out.deepest = largest(deepest);
  }
};

/// The clusters of a chunk that can have a point within the limit, as bits; lowers `nearest` to the distance
/// of the others.
inline std::uint64_t clustersWithin(const SampleView& samples, const RelativeFrame& frame,
                                    const FieldView& field, int begin, int count, float limit,
                                    Lanes& nearest) {
  std::uint64_t members = 0;
  for (int group = 0; group < count; group += width) {
    const int at = begin + group;
    const Point center =
        transform(frame, load(samples.centerX + at), load(samples.centerY + at), load(samples.centerZ + at));
    const Lanes apart = lowerBound(field, center) - frame.scale * load(samples.radius + at);
    const std::uint64_t close = bitsWhereLess(apart, splat(limit));
    nearest = smaller(nearest, larger(apart, splat(limit)));
    members |= close << group;
  }
  return members;
}

/// contact() for one kind of field.
template <bool onGrid>
inline __attribute__((always_inline)) void contactWith(const SampleView& samples, const RelativeFrame& frame,
                                                       const FieldView& field, float clearance, float margin,
                                                       ClusterMask& mask, ContactSums& out) {
  const bool everywhere = mask == allClusters;
  const float limit = everywhere ? clearance + margin : clearance;
  ClusterMask near = 0, touchedClusters = 0;
  LaneSums running;
  Lanes nearest = splat(1e30f);
  bool touching = false;
  for (int begin = 0; begin < samples.clusters; begin += chunk) {
    const int count = samples.clusters - begin < chunk ? samples.clusters - begin : chunk;
    std::uint64_t members = mask;
    if (everywhere)
      members = clustersWithin(samples, frame, field, begin, count, limit, nearest);
    else if (samples.bitShift > 0)
      for (int k = (members = 0); k < count; ++k)
        members |= (mask >> ((begin + k) >> samples.bitShift) & 1u) << k;
    if (count < chunk) members &= (std::uint64_t{1} << count) - 1u;

    // First pass: which clusters come within the limit, and which touch. Free of branches, so that the
    // processor can overlap several of them.
    NearCluster kept[chunk];
    int touched[chunk], keptCount = 0, touchedCount = 0, looked = 0;
    for (; members != 0; members &= members - 1, ++looked) {
      const int cluster = begin + __builtin_ctzll(members);
      const int first = cluster * width;
      NearCluster& slot = kept[keptCount];
      slot.q = transform(frame, load(samples.x + first), load(samples.y + first), load(samples.z + first));
      slot.level = onGrid ? sampled(field, slot.q) : closedForm(field, slot.q);
      unsigned within, touch;
      if (onGrid) {
        within = bitsWhereLess(slot.level.f, splat(limit));
        touch = bitsWhereLess(slot.level.f, splat(clearance));
      } else {
        // F / |grad F| does not exceed the distance where F is convex, which holds around any ellipsoid, and
        // around red cells too.
        const Lanes signedSquare = slot.level.f * magnitude(slot.level.f);
        within = bitsWhereLess(signedSquare, (4.0f * limit * limit) * slot.level.quarter);
        touch = bitsWhereLess(signedSquare, (4.0f * clearance * clearance) * slot.level.quarter);
      }
      touched[touchedCount] = keptCount;
      touchedCount += touch != 0;
      touchedClusters |= static_cast<ClusterMask>(touch != 0) << (cluster >> samples.bitShift);
      keptCount += within != 0;
      near |= static_cast<ClusterMask>(within != 0) << (cluster >> samples.bitShift);
    }
    if (keptCount < looked) nearest = smaller(nearest, splat(limit));

    // Second pass: d = F / (|grad F|/2 + sqrt(|grad F|²/4 - F)), the smaller root of d² - |grad F| d + F = 0:
    // exact for spheres, within 0.0006 µm of the distance near the surface of a red cell; outside, between F
    // / |grad F| and twice that. Inside an ellipsoid F under the root is multiplied by the curvature, so that
    // the depth never exceeds the true one. Otherwise the depth in the middle would be half the extent along
    // y, and cells would lock.
    for (int k = 0; k < touchedCount; ++k) {
      const NearCluster& cluster = kept[touched[k]];
      const Level& level = cluster.level;
      const Lanes half = larger(squareRoot(level.quarter), splat(1e-6f));
      Lanes distance = level.f;
      if (!onGrid) {
        const Lanes curved = smaller(level.f, field.curvature * level.f);
        distance = level.f / (half + squareRoot(larger(level.quarter - curved, splat(0.0f))));
      }
      running.add(cluster, larger(clearance - distance, splat(0.0f)), 2.0f * half);
    }
    if (touchedCount > 0) touching = touching || bitsWhereLess(splat(0.0f), running.deepest) != 0;
    if (!touching)
      for (int k = 0; k < keptCount; ++k) {
        const Level& level = kept[k].level;
        // The lower limit of the gradient only keeps the quotient finite.
        nearest = smaller(
            nearest, onGrid ? level.f : level.f / larger(2.0f * squareRoot(level.quarter), splat(1e-6f)));
      }
  }
  if (everywhere) mask = near;
  out.weight = 0.0f;
  out.touched = touchedClusters;
  if (!touching) {
    out.nearest = smallest(nearest);
    return;
  }
  running.store(out);
  out.nearest = clearance - out.deepest;
}

void contact(const SampleView& samples, const RelativeFrame& frame, const FieldView& field, float clearance,
             float margin, ClusterMask& mask, ContactSums& out) {
  if (field.onGrid)
    contactWith<true>(samples, frame, field, clearance, margin, mask, out);
  else
    contactWith<false>(samples, frame, field, clearance, margin, mask, out);
}

}  // namespace

template <InstructionSet set>
ContactKernel contactKernel() {
  return contact;
}
template ContactKernel contactKernel<InstructionSet::PACKMESH_INSTRUCTION_SET>();

}  // namespace packmesh
