// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The builders of planes by name.
#pragma once

#include "packMesh/growth/growth_state.h"
#include "packMesh/growth/tetgen_planes.h"

namespace packmesh {

/// Where the planes come from that cells grow in.
enum class Builder {
  chords,    ///< shortest chords between neighbours, from distance fields
  tetgen,    ///< the same between cells that tetrahedra join
  catFaces,  ///< CAT faces of tetrahedra, as in the thesis
};

/// References the scene and the sums, which must outlive it.
/// @param sums what tetrahedra take is added here
PlaneBuilder makeBuilder(Builder builder, const GrowthScene& scene, TetrahedraSums& sums);

}  // namespace packmesh
