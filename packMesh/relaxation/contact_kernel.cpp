// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/contact_kernels.h"

#include "packMesh/shape/field_lanes.h"

namespace packmesh {
namespace {

constexpr int width = laneCount;

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
