// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Coarser meshes of a surface (thesis eq. 3.4).
#pragma once

#include <optional>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Fraction of the vertices to be used (eq. 3.4): ρ(k) = α (1 + α^(1/β) - k)^(-β).
///
/// As printed, the exponent applies to k alone, which gives some 1 % for all k; in this form ρ rises from
/// about α at k = 0 to exactly 1 at k = 1, as the thesis states.
/// @param progress k, 0 at the initial scale, 1 at full scale
/// Pre: 0 < alpha <= 1, beta > 0
double resamplingFactor(double progress, double alpha, double beta);

/// The mesh of which `mesh` is the refinement, with every triangle divided into four (HemoCell's cells,
/// refined icosahedra and octahedra); its vertices are a subset of those of `mesh`. Empty if it is not such a
/// refinement.
std::optional<TriangleMesh> unrefined(const TriangleMesh& mesh);

/// `mesh` with about `vertices` vertices, a subset of its own: edges are collapsed in the order of the
/// quadric error (M. Garland, P. Heckbert, SIGGRAPH 1997; OpenMesh). It may have more if fewer would not form
/// a closed surface.
TriangleMesh decimated(const TriangleMesh& mesh, int vertices);

/// One mesh in several levels of detail.
class LevelsOfDetail {
 public:
  /// Each level has a quarter of the vertices of the previous one, from unrefined() if possible, otherwise
  /// from decimated(); the coarsest one has at least 40 vertices, and none intersects itself.
  explicit LevelsOfDetail(const TriangleMesh& mesh);

  /// The level whose fraction of the vertices is nearest to `share`, as a ratio.
  const TriangleMesh& level(double share) const { return meshes_[indexOf(share)]; }
  int indexOf(double share) const;
  int count() const { return static_cast<int>(meshes_.size()); }
  const TriangleMesh& mesh(int index) const { return meshes_[index]; }

 private:
  std::vector<TriangleMesh> meshes_;  ///< the mesh itself first
};

}  // namespace packmesh
