// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/plane_source.h"

#include <memory>

#include "packMesh/growth/chord_planes.h"

namespace packmesh {

PlaneFunction makePlaneFunction(PlaneSource planeSource, const GrowthScene& scene, TetrahedraSums& sums) {
  if (planeSource == PlaneSource::chords) {
    const auto chords = std::make_shared<const ChordPlanes>(scene);
    return
        [chords](const GrowthState& state, const PlaneRequest& request) { return (*chords)(state, request); };
  }
  const auto faces = std::make_shared<CatFacePlanes>(scene, sums);
  return [faces](const GrowthState& state, const PlaneRequest& request) { return (*faces)(state, request); };
}

}  // namespace packmesh
