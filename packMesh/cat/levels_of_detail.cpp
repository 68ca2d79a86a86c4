// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/levels_of_detail.h"

#include <algorithm>
#include <cmath>

#include "packMesh/cat/resampling.h"
#include "packMesh/mesh/self_intersection.h"

namespace packmesh {
namespace {

constexpr std::size_t fewestVertices = 40;
constexpr double levelFactor = 4.0;

}  // namespace

LevelsOfDetail::LevelsOfDetail(const TriangleMesh& mesh) : meshes_{mesh} {
  for (;;) {
    const TriangleMesh& last = meshes_.back();
    const auto wanted = static_cast<int>(static_cast<double>(last.vertices.size()) / levelFactor);
    if (static_cast<std::size_t>(wanted) + 2 < fewestVertices) break;
    std::optional<TriangleMesh> coarser = unrefined(last);
    if (!coarser) coarser = decimated(last, wanted);
    const bool useful = coarser->vertices.size() >= fewestVertices &&
                        2 * coarser->vertices.size() < last.vertices.size() &&
                        !findSelfIntersection(*coarser);
    if (!useful) break;
    meshes_.push_back(std::move(*coarser));
  }
}

int LevelsOfDetail::indexOf(double share) const {
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < count(); ++i) {
    const double has = static_cast<double>(meshes_[i].vertices.size()) / meshes_[0].vertices.size();
    const double off = std::abs(std::log(has / std::max(share, 1e-6)));  // finite for 0
    if (off < least) {
      least = off;
      best = i;
    }
  }
  return best;
}

}  // namespace packmesh
