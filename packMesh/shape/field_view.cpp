// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/shape/field_view.h"

#include "packMesh/shape/sample_points.h"

namespace packmesh {

SampleView viewOf(const SamplePoints& s) {
  int shift = 0;
  while (s.clusters > 64 << shift) ++shift;
  return {s.clusters,       shift,
          s.x.data(),       s.y.data(),
          s.z.data(),       s.centerX.data(),
          s.centerY.data(), s.centerZ.data(),
          s.radius.data()};
}

}  // namespace packmesh
