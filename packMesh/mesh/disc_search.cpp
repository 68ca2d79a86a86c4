// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/disc_search.h"

#include <algorithm>
#include <limits>

#include "packMesh/mesh/triangle_facts.h"

namespace packmesh {

DiscSearch::DiscSearch(const MeshTree& tree, const ClosestPoint& surface)
    : tree_(tree), surface_(surface), kernels_(triangleKernels(chosenInstructionSet())) {
  facts_.reserve(tree.mesh.triangles.size());
  for (std::size_t t = 0; t < tree.mesh.triangles.size(); ++t)
    facts_.push_back(factsOf(tree.mesh, static_cast<int>(t)));
}

void DiscSearch::search(Query& query) const {
  struct Context {
    Query& query;
    const ClosestPoint& surface;
    float slack;
  };
  double furthest = 0.0;
  for (const Vec3& p : query.point) furthest = std::max(furthest, p.norm());
  const float slack = static_cast<float>(slackAt(furthest));
  PointLanes lanes;
  float limits[points];
  for (int k = 0; k < points; ++k) {
    lanes.x[k] = static_cast<float>(query.point[k].x());
    lanes.y[k] = static_cast<float>(query.point[k].y());
    lanes.z[k] = static_cast<float>(query.point[k].z());
    const double atMost = query.atMost[k];
    limits[k] = atMost < 0.0
                    ? -1.0f
                    : static_cast<float>(std::min((1.0 + searchGrowth) * atMost * atMost + slack, 1e30));
    query.nearest[k] = {std::numeric_limits<double>::infinity(), -1, 6, query.point[k]};
  }
  Context context{query, surface_, slack};
  const auto examine = [](void* data, const int* triangles, const float* squared, int count,
                          float(&most)[points]) {
    const Context& c = *static_cast<const Context*>(data);
    for (int k = 0; k < points; ++k)
      for (int t = 0; t < count; ++t) {
        if (squared[points * t + k] > most[k]) continue;
        const ClosestPoint::Nearest found = c.surface.onTriangle(triangles[t], c.query.point[k]);
        if (found.distance < c.query.nearest[k].distance) c.query.nearest[k] = found;
      }
  };
  kernels_.search(lanes, tree_.quads.data(), facts_.data(), slack, limits, examine, &context);
}

}  // namespace packmesh
