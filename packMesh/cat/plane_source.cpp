// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/plane_source.h"

#include "packMesh/cat/cat_face_planes.h"
#include "packMesh/cat/chord_planes.h"

namespace packmesh {

std::unique_ptr<PlaneFunction> makePlaneFunction(PlaneSource planeSource, const Physics& physics,
                                                 const Execution& execution, TetrahedraSums& sums) {
  if (planeSource == PlaneSource::chords) return std::make_unique<ChordPlanes>(physics);
  return std::make_unique<CatFacePlanes>(physics, execution, sums);
}

}  // namespace packmesh
