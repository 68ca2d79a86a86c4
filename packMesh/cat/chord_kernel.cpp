// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/growth_kernels.h"

#include "packMesh/shape/field_lanes.h"

namespace packmesh {
namespace {

constexpr int width = laneCount;

/// Clusters of one word of bits.
constexpr int chunk = 64;

/// Stands for a vanishing gradient, which has no direction.
constexpr float flat = 1e-12f;

/// From a point as far away as a cell is wide.
constexpr int newtonSteps = 6;

inline Lanes dot(const Point& a, const Point& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Point plus(const Point& a, const Lanes& factor, const Point& b) {
  return {a.x + factor * b.x, a.y + factor * b.y, a.z + factor * b.z};
}
inline Point choose(const Mask& m, const Point& a, const Point& b) {
  return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}
inline Point turned(const float* r, const Point& p) {
  return {r[0] * p.x + r[1] * p.y + r[2] * p.z, r[3] * p.x + r[4] * p.y + r[5] * p.z,
          r[6] * p.x + r[7] * p.y + r[8] * p.z};
}

/// The sampled distance and its gradient per length; outside the grid the value at the nearest point of it
/// plus the distance to it: as DistanceGrid::sample().
inline Level sampledBeyond(const FieldView& field, const Point& p) {
  const float spacing = 1.0f / field.nodesPerLength;
  const Lanes zero = splat(0.0f);
  const Lanes* const of[3] = {&p.x, &p.y, &p.z};
  Lanes inside[3], beyond[3];
  for (int k = 0; k < 3; ++k) {
    const float low = field.origin[k], high = low + spacing * (static_cast<float>(field.nodes[k]) - 1.0f);
    inside[k] = smaller(larger(*of[k], splat(low)), splat(high));
    beyond[k] = *of[k] - inside[k];
  }
  Level level = sampled(field, {inside[0], inside[1], inside[2]});
  const Point outward{beyond[0], beyond[1], beyond[2]};
  const Lanes length = squareRoot(dot(outward, outward)), inverse = splat(1.0f) / larger(length, splat(flat));
  level.f += length;
  Lanes* const slope[3] = {&level.gradient.x, &level.gradient.y, &level.gradient.z};
  for (int k = 0; k < 3; ++k)
    *slope[k] = select(zero < magnitude(beyond[k]), inverse * beyond[k], field.nodesPerLength * *slope[k]);
  level.quarter = quarterOf(level.gradient);
  return level;
}

template <bool onGrid>
inline __attribute__((always_inline)) Level levelAt(const FieldView& field, const Point& p) {
  return onGrid ? sampledBeyond(field, p) : closedForm(field, p);
}

/// Distance from the surface, and a unit vector away from it: as SurfaceDistance::sample().
struct Away {
  Lanes distance;
  Point gradient;
};

template <bool onGrid>
inline __attribute__((always_inline)) Away awayAt(const FieldView& field, const Level& level) {
  const Lanes half = squareRoot(level.quarter), inverse = splat(1.0f) / larger(2.0f * half, splat(flat));
  Away away{level.f, {inverse * level.gradient.x, inverse * level.gradient.y, inverse * level.gradient.z}};
  if (!onGrid) {
    const Lanes curved = smaller(level.f, field.curvature * level.f);
    away.distance =
        level.f / larger(half + squareRoot(larger(level.quarter - curved, splat(0.0f))), splat(flat));
  }
  return away;
}

/// One step of Newton's method from p to the surface of a closed form.
inline Point newtonStep(const FieldView& field, const Point& p) {
  const Level level = closedForm(field, p);
  return plus(p, (splat(0.0f) - level.f) / larger(4.0f * level.quarter, splat(flat)), level.gradient);
}

/// The point of the surface nearest to p, up to the error of the distance: as SurfaceDistance::foot().
template <bool onGrid>
inline __attribute__((always_inline)) Point footOf(const FieldView& field, const Point& p, const Away& away) {
  const Point first = plus(p, splat(0.0f) - away.distance, away.gradient);
  if (onGrid) {
    const Away rest = awayAt<true>(field, sampledBeyond(field, first));
    return plus(first, splat(0.0f) - rest.distance, rest.gradient);
  }
  const Point second = newtonStep(field, first), step = plus(second, splat(-1.0f), first);
  const Mask good = dot(step, step) < 0.05f * away.distance * away.distance;
  if (bitsOf(good) == (1u << width) - 1u) return second;
  // So far away the distance is overestimated; Newton's steps come from outside and do not overshoot.
  Point far = p;
  for (int k = 0; k < newtonSteps; ++k) far = newtonStep(field, far);
  return choose(good, second, far);
}

/// The clusters of a chunk that can have a point within the limit, as bits.
inline std::uint64_t clustersWithin(const SampleView& samples, const ChordFrame& frame,
                                    const FieldView& field, int begin) {
  const int count = samples.clusters - begin < chunk ? samples.clusters - begin : chunk;
  std::uint64_t members = 0;
  for (int group = 0; group < count; group += width) {
    const int at = begin + group;
    const Point center = transform(frame.toSurface, load(samples.centerX + at), load(samples.centerY + at),
                                   load(samples.centerZ + at));
    const Lanes apart = lowerBound(field, center) - frame.toSurface.scale * load(samples.radius + at);
    members |= std::uint64_t{bitsWhereLess(apart, splat(frame.limit))} << group;
  }
  return count < chunk ? members & ((std::uint64_t{1} << count) - 1u) : members;
}

/// Points of a chunk that are near the surface, one after the other.
struct NearPoints {
  float x[chunk * width + width], y[chunk * width + width], z[chunk * width + width];
  int count = 0;
};

template <bool onGrid>
inline __attribute__((always_inline)) void gatherNear(const SampleView& samples,
                                                      const std::uint16_t* distinct, const ChordFrame& frame,
                                                      const FieldView& field, int begin, NearPoints& near) {
  near.count = 0;
  for (std::uint64_t members = clustersWithin(samples, frame, field, begin); members != 0;
       members &= members - 1) {
    const int cluster = begin + __builtin_ctzll(members), first = cluster * width;
    const Lanes x = load(samples.x + first), y = load(samples.y + first), z = load(samples.z + first);
    const Level level = levelAt<onGrid>(field, transform(frame.toSurface, x, y, z));
    // F / |grad F| does not exceed the distance of a closed form.
    const unsigned close = onGrid ? bitsWhereLess(level.f, splat(frame.limit))
                                  : bitsWhereLess(level.f * magnitude(level.f),
                                                  (4.0f * frame.limit * frame.limit) * level.quarter);
    const unsigned bits = close & distinct[cluster];
    storeWhere(bits, x, near.x + near.count);
    storeWhere(bits, y, near.y + near.count);
    storeWhere(bits, z, near.z + near.count);
    near.count += __builtin_popcount(bits);
  }
  store(splat(0.0f), near.x + near.count);
  store(splat(0.0f), near.y + near.count);
  store(splat(0.0f), near.z + near.count);
}

inline void storePlane(unsigned bits, const Point& arm, const Point& normal, const Lanes& distance, int at,
                       float* const* out) {
  storeWhere(bits, arm.x, out[0] + at);
  storeWhere(bits, arm.y, out[1] + at);
  storeWhere(bits, arm.z, out[2] + at);
  storeWhere(bits, normal.x, out[3] + at);
  storeWhere(bits, normal.y, out[4] + at);
  storeWhere(bits, normal.z, out[5] + at);
  storeWhere(bits, distance, out[6] + at);
}

template <bool onGrid>
inline __attribute__((always_inline)) int chordsOnto(const SampleView& samples, const std::uint16_t* distinct,
                                                     const ChordFrame& frame, const FieldView& field,
                                                     const ChordPlanesOut& out) {
  int found = 0;
  NearPoints near;
  const float* t = frame.toSurface.t;
  for (int begin = 0; begin < samples.clusters; begin += chunk) {
    gatherNear<onGrid>(samples, distinct, frame, field, begin, near);
    for (int k = 0; k < near.count; k += width) {
      const int left = near.count - k;
      const Point vertex{load(near.x + k), load(near.y + k), load(near.z + k)};
      const Point p = transform(frame.toSurface, vertex.x, vertex.y, vertex.z);
      const Away away = awayAt<onGrid>(field, levelAt<onGrid>(field, p));
      unsigned bits = ~bitsWhereLess(splat(frame.limit), away.distance) & ((1u << width) - 1u);
      if (left < width) bits &= (1u << left) - 1u;
      if (bits == 0) continue;
      const Point foot = footOf<onGrid>(field, p, away), chord = plus(foot, splat(-1.0f), p);
      const Lanes length = squareRoot(dot(chord, chord)), inverse = splat(1.0f) / larger(length, splat(flat));
      const Mask directed = (splat(0.0f) < away.distance) & (splat(frame.shortChord) < length);
      const Point along = {inverse * chord.x, inverse * chord.y, inverse * chord.z};
      const Point inward = {splat(0.0f) - away.gradient.x, splat(0.0f) - away.gradient.y,
                            splat(0.0f) - away.gradient.z};
      const Point normal = choose(directed, along, inward);
      const Lanes height = frame.scale * dot(normal, plus(p, splat(frame.share), chord)) + frame.offset;
      const Point world = turned(frame.surface, normal);
      if (out.sampled) {
        const Lanes between = t[0] * normal.x + t[1] * normal.y + t[2] * normal.z;
        storePlane(bits, turned(frame.sampled, vertex), world, height - frame.scale * between, found,
                   out.sampled);
      }
      if (out.surface) {
        const Lanes zero = splat(0.0f);
        storePlane(bits, turned(frame.surface, foot), {zero - world.x, zero - world.y, zero - world.z},
                   zero - height, found, out.surface);
      }
      found += __builtin_popcount(bits);
    }
  }
  return found;
}

int chords(const SampleView& samples, const std::uint16_t* distinct, const ChordFrame& frame,
           const FieldView& field, const ChordPlanesOut& out) {
  return field.onGrid ? chordsOnto<true>(samples, distinct, frame, field, out)
                      : chordsOnto<false>(samples, distinct, frame, field, out);
}

}  // namespace

template <InstructionSet set>
ChordKernel chordKernel() {
  return chords;
}
template ChordKernel chordKernel<InstructionSet::PACKMESH_INSTRUCTION_SET>();

}  // namespace packmesh
