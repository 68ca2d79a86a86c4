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

void nearestTriangles(const PointLanes& points, const TriangleFacts* triangles, const int* chosen, int count,
                      float (&squared)[16], float (&nearest)[16]) {
  const Point p{load(points.x), load(points.y), load(points.z)};
  Lanes best = splat(1e30f), which = splat(0.0f);
  for (int c = 0; c < count; ++c) {
    const Lanes square = squaredDistance(p, triangles[chosen[c]]);
    which = select(square < best, splat(static_cast<float>(c)), which);
    best = smaller(square, best);
  }
  store(best, squared);
  store(which, nearest);
}

void triangleDistances(const PointLanes& points, const TriangleFacts* triangles, int count, float* squared) {
  const Point p{load(points.x), load(points.y), load(points.z)};
  for (int c = 0; c < count; ++c) store(squaredDistance(p, triangles[c]), squared + laneCount * c);
}

/// Upper bound of the error of squared distances from a disc, relative to the squared distance from its
/// centre: about thirty roundings.
constexpr float discRounding = 2e-6f;

/// A lower bound of the squared distances from a disc: it is between two planes and, along them, within its
/// radius.
inline Lanes squaredFromDisc(const Point& p, const FourDiscs& discs, int k) {
  const Point from{p.x - discs.center[0][k], p.y - discs.center[1][k], p.z - discs.center[2][k]};
  const float normal[3] = {discs.normal[0][k], discs.normal[1][k], discs.normal[2][k]};
  const Lanes none = splat(0.0f), along = dot(from, normal);
  const Lanes length2 = from.x * from.x + from.y * from.y + from.z * from.z;
  const Lanes across2 = larger(length2 - along * along, none);
  const Lanes height = larger(magnitude(along) - discs.half[k], none),
              beyond = larger(squareRoot(across2) - discs.radius[k], none);
  return height * height + beyond * beyond - discRounding * length2;
}

struct Waiting {
  Lanes squared;
  int content;  ///< as DiscQuad::content
};

/// Trees of quads are not deeper than 34, and each step down leaves at most three entries.
constexpr int waitingMost = 128;

/// Triangles that are examined together.
constexpr int examinedMost = 32;

constexpr unsigned allLanes = (1u << laneCount) - 1;

inline bool anyWithin(const Lanes& squared, const Lanes& limit) {
  return (~bitsOf(limit < squared) & allLanes) != 0;
}

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
      limit = smaller((1.0f + searchGrowth) * square + slack, limit);
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
  return {nearestTriangles, triangleDistances, searchNear};
}
template TriangleKernels triangleKernels<InstructionSet::PACKMESH_INSTRUCTION_SET>();

}  // namespace packmesh
