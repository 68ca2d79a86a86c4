// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The sources of planes by name.
#pragma once

#include <memory>

#include "packMesh/growth/cat_face_planes.h"

namespace packmesh {

/// Where the planes come from that cells grow in.
enum class PlaneSource {
  chords,  ///< shortest chords between neighbours, from distance fields
  /// CAT faces of tetrahedra, as in the thesis. Digests of problems hold the number: 1 was another source.
  catFaces = 2,
};

/// References the scene and the sums, which must outlive it.
/// @param sums what tetrahedra take is added here
std::unique_ptr<PlaneFunction> makePlaneFunction(PlaneSource planeSource, const GrowthScene& scene,
                                                 TetrahedraSums& sums);

}  // namespace packmesh
