// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/shape/field_view.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "packMesh/shape/shape.h"

namespace packmesh {

FieldView viewOf(const Shape& shape) {
  FieldView view{};
  if (const auto* profile = std::get_if<ProfileSurface>(&shape.field())) {
    view.onGrid = false;
    for (int k = 0; k < 6; ++k) view.p[k] = static_cast<float>(profile->p[k]);
    view.a = static_cast<float>(profile->a);
    view.c = static_cast<float>(profile->c);
    view.bend = static_cast<float>(profile->bendBeyondRim());
    view.curvature = static_cast<float>(profile->curvatureInside());
  } else {
    const auto& grid = std::get<DistanceGrid>(shape.field());
    view.onGrid = true;
    view.value = grid.value.data();
    view.nodesPerLength = static_cast<float>(1.0 / grid.spacing);
    for (int k = 0; k < 3; ++k) {
      view.origin[k] = static_cast<float>(grid.origin[k]);
      view.nodes[k] = grid.nodes[k];
    }
  }
  const SupportBound& bound = shape.bound();
  view.ring = static_cast<float>(bound.ring);
  view.thickness = static_cast<float>(bound.semiAxes.maxCoeff());
  const Box box = boundingBox(shape.mesh());
  for (int k = 0; k < 3; ++k)
    view.extent[k] = static_cast<float>(std::max(std::abs(box.lo[k]), std::abs(box.hi[k])));
  return view;
}

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
