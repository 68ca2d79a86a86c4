// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Coordinates that meshes can have.
#pragma once

#include <string>

#include "packMesh/core/tolerances.h"
#include "packMesh/core/vector_text.h"

namespace packmesh {

/// What is wrong with the coordinates of a vertex, beginning with a blank, to follow its name; empty:
/// nothing.
inline std::string coordinateFault(const Vec3& v) {
  if (!v.allFinite()) return " has a coordinate that is not a finite number";
  int axis = 0;
  if (v.cwiseAbs().maxCoeff(&axis) <= tolerance::largestCoordinate) return {};
  return std::string(" has the coordinate ") + axisName[axis] + " = " + toText(v[axis], 3) + ", at most " +
         toText(tolerance::largestCoordinate, 3) + " is possible; is the file damaged?";
}

}  // namespace packmesh
