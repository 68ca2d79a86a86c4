// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/plane_source.h"

#include "packMesh/growth/chord_planes.h"

namespace packmesh {

std::unique_ptr<PlaneFunction> makePlaneFunction(PlaneSource planeSource, const GrowthScene& scene,
                                                 TetrahedraSums& sums) {
  if (planeSource == PlaneSource::chords) return std::make_unique<ChordPlanes>(scene);
  return std::make_unique<CatFacePlanes>(scene, sums);
}

}  // namespace packmesh
