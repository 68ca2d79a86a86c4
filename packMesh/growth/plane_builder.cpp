// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/plane_builder.h"

#include <memory>

#include "packMesh/growth/chord_planes.h"

namespace packmesh {

PlaneBuilder makeBuilder(Builder builder, const GrowthScene& scene, TetrahedraSums& sums) {
  if (builder == Builder::chords) {
    const auto chords = std::make_shared<const ChordPlanes>(scene);
    return
        [chords](const GrowthState& state, const PlaneRequest& request) { return (*chords)(state, request); };
  }
  const TetgenUse use = builder == Builder::tetgen ? TetgenUse::facing : TetgenUse::faces;
  const auto tetgen = std::make_shared<TetgenPlanes>(scene, use, sums);
  return
      [tetgen](const GrowthState& state, const PlaneRequest& request) { return (*tetgen)(state, request); };
}

}  // namespace packmesh
