// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/triangle_kernel.h"
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

}  // namespace

template <InstructionSet set>
TriangleKernels triangleKernels() {
  return {nearestTriangles, triangleDistances};
}
template TriangleKernels triangleKernels<InstructionSet::PACKMESH_INSTRUCTION_SET>();

}  // namespace packmesh
