// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/mesh_kernels.h"
#include "packMesh/simd/lanes.h"

namespace packmesh {
namespace {

struct Point {
  Lanes x, y, z;
};

inline Lanes dot(const Point& p, const float (&v)[3]) {
  return v[0] * p.x + v[1] * p.y + v[2] * p.z;
}

inline Lanes squaredDistance(const Point& p, const TriangleFacts& t) {
  Lanes toEdge = splat(1e30f), inside = splat(1e30f), height = splat(0.0f);
  for (int e = 0; e < 3; ++e) {
    const Point from{p.x - t.corner[e][0], p.y - t.corner[e][1], p.z - t.corner[e][2]};
    const Lanes along = smaller(larger(t.perSquare[e] * dot(from, t.edge[e]), splat(0.0f)), splat(1.0f));
    const Point rest{from.x - t.edge[e][0] * along, from.y - t.edge[e][1] * along,
                     from.z - t.edge[e][2] * along};
    toEdge = smaller(rest.x * rest.x + rest.y * rest.y + rest.z * rest.z, toEdge);
    inside = smaller(dot(from, t.inward[e]), inside);
    if (e == 0) height = dot(from, t.normal);
  }
  return select(splat(0.0f) < inside, height * height, toEdge);
}

/// Upper bound of the error of squared distances from a disc, relative to the squared distance from its
/// centre: about thirty roundings.
constexpr float discRounding = 2e-6f;

/// A lower bound of the squared distances from a disc: it is between two planes and, along them, within its
/// radius.
/// @param from its centre
inline Lanes squaredFromDisc(const Point& from, const float (&normal)[3], float radius, float half) {
  const Lanes none = splat(0.0f), along = dot(from, normal);
  const Lanes length2 = from.x * from.x + from.y * from.y + from.z * from.z;
  const Lanes across2 = larger(length2 - along * along, none);
  const Lanes height = larger(magnitude(along) - half, none),
              beyond = larger(squareRoot(across2) - radius, none);
  return height * height + beyond * beyond - discRounding * length2;
}

inline Lanes squaredFromDisc(const Point& p, const FourDiscs& discs, int k) {
  const float normal[3] = {discs.normal[0][k], discs.normal[1][k], discs.normal[2][k]};
  return squaredFromDisc({p.x - discs.center[0][k], p.y - discs.center[1][k], p.z - discs.center[2][k]},
                         normal, discs.radius[k], discs.half[k]);
}

constexpr unsigned allLanes = (1u << laneCount) - 1;

inline bool anyWithin(const Lanes& squared, const Lanes& limit) {
  return bitsWhereLess(limit, squared) != allLanes;
}

inline Lanes withSlack(const Lanes& squared, float slack) {
  return (1.0f + searchGrowth) * squared + slack;
}

/// Squared distances from a box to sixteen points.
struct PointsBox {
  Lanes center[3], half[3];

  explicit PointsBox(const Point& p) {
    const Lanes* along[3] = {&p.x, &p.y, &p.z};
    for (int k = 0; k < 3; ++k) {
      const float lo = smallest(*along[k]), hi = largest(*along[k]);
      center[k] = splat(0.5f * (lo + hi));
      half[k] = splat(0.5f * (hi - lo));
    }
  }
  Lanes squaredDistance(const Point& to) const {
    const Lanes* along[3] = {&to.x, &to.y, &to.z};
    Lanes sum = splat(0.0f);
    for (int k = 0; k < 3; ++k) {
      const Lanes beyond = larger(magnitude(*along[k] - center[k]) - half[k], splat(0.0f));
      sum += beyond * beyond;
    }
    return sum;
  }
};

/// Begins with the triangle whose centre is nearest to the box around the points. Others are left out by
/// their distance from that box, and by that of each point from their discs.
void nearestTriangles(const PointLanes& points, const NearDiscs& near, float slack, float* scratch,
                      CandidateFacts factsOf, void* context, float (&squared)[16], float (&nearest)[16]) {
  const Point p{load(points.x), load(points.y), load(points.z)};
  const PointsBox box(p);
  Lanes least = splat(1e30f), from = splat(0.0f);
  for (int group = 0; group < near.count; group += laneCount) {
    const Lanes square =
        box.squaredDistance({load(near.x + group), load(near.y + group), load(near.z + group)});
    store(square, scratch + group);
    from = select(square < least, splat(static_cast<float>(group)), from);
    least = smaller(square, least);
  }
  float leasts[laneCount], groups[laneCount];
  store(least, leasts);
  store(from, groups);
  int lane = 0;
  for (int k = 1; k < laneCount; ++k)
    if (leasts[k] < leasts[lane]) lane = k;
  const int first = static_cast<int>(groups[lane]) + lane;
  Lanes best = squaredDistance(p, factsOf(context, first)), which = splat(static_cast<float>(first));
  Lanes limit = withSlack(best, slack);
  float reach = __builtin_sqrtf(largest(best));
  for (int group = 0; group < near.count; group += laneCount) {
    const Lanes within = reach + load(near.radius + group);
    bool nearer = false;
    for (unsigned bits = bitsWhereLess(load(scratch + group), withSlack(within * within, slack)); bits != 0;
         bits &= bits - 1) {
      const int c = group + __builtin_ctz(bits);
      if (c == first) continue;
      const TriangleDisc& disc = near.discs[near.triangles[c]];
      const Lanes bound = squaredFromDisc({p.x - near.x[c], p.y - near.y[c], p.z - near.z[c]}, disc.normal,
                                          disc.radius, disc.half);
      if (!anyWithin(bound, limit)) continue;
      const Lanes square = squaredDistance(p, factsOf(context, c));
      which = select(square < best, splat(static_cast<float>(c)), which);
      best = smaller(square, best);
      limit = withSlack(best, slack);
      nearer = true;
    }
    if (nearer) reach = __builtin_sqrtf(largest(best));
  }
  store(best, squared);
  store(which, nearest);
}

struct Waiting {
  Lanes squared;
  int content;  ///< as DiscQuad::content
};

/// Trees of quads are not deeper than 34, and each step down leaves at most three entries.
constexpr int waitingMost = 128;

/// Triangles that are examined together.
constexpr int examinedMost = 32;

void searchNear(const PointLanes& points, const DiscQuad* quads, const TriangleFacts* triangles, float slack,
                float (&limits)[16], ExamineNear examine, void* context) {
  const Point p{load(points.x), load(points.y), load(points.z)};
  Lanes limit = load(limits);
  Waiting stack[waitingMost];
  int found[examinedMost], count = 0, top = 0;
  float squared[examinedMost * laneCount];
  const auto examineFound = [&] {
    store(limit, limits);
    examine(context, found, squared, count, limits);
    limit = load(limits);
    count = 0;
  };
  stack[top++] = {splat(0.0f), 0};
  while (top > 0) {
    const Waiting next = stack[--top];
    if (!anyWithin(next.squared, limit)) continue;
    if (next.content < 0) {
      const Lanes square = squaredDistance(p, triangles[~next.content]);
      limit = smaller(withSlack(square, slack), limit);
      if (!anyWithin(square, limit)) continue;
      store(square, squared + laneCount * count);
      found[count++] = ~next.content;
      if (count == examinedMost) examineFound();
      continue;
    }
    const DiscQuad& quad = quads[next.content];
    const int before = top;
    for (int k = 0; k < 4; ++k) {
      if (quad.discs.half[k] < 0.0f) continue;
      const Lanes bound = squaredFromDisc(p, quad.discs, k);
      if (!anyWithin(bound, limit)) continue;
      int place = top++;  // the nearest to the first point on top
      for (; place > before && stack[place - 1].squared.r[0][0] < bound.r[0][0]; --place)
        stack[place] = stack[place - 1];
      stack[place] = {bound, quad.content[k]};
    }
  }
  if (count > 0) examineFound();
}

}  // namespace

template <InstructionSet set>
TriangleKernels triangleKernels() {
  return {nearestTriangles, searchNear};
}
template TriangleKernels triangleKernels<InstructionSet::PACKMESH_INSTRUCTION_SET>();

}  // namespace packmesh
