// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The constructions of planes by name.
#pragma once

#include <memory>

#include "packMesh/growth/cat_face_planes.h"

namespace packmesh {

/// Construction of the planes within which cells grow.
enum class PlaneSource {
  chords,  ///< shortest chords between neighbours, from distance fields
  /// CAT faces of tetrahedra, as in the thesis. Digests of problems contain the number; 1 was another source.
  catFaces = 2,
};

/// References the scene and the sums, which must outlive it.
/// @param sums statistics of tetrahedralisation are added to this
std::unique_ptr<PlaneFunction> makePlaneFunction(PlaneSource planeSource, const GrowthScene& scene,
                                                 TetrahedraSums& sums);

}  // namespace packmesh
