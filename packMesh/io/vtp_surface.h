// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Surfaces as .vtp files.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Triangles, or lines, with whole numbers for each.
struct VtpSurface {
  std::vector<Vec3> points;  ///< [µm]
  std::vector<Triangle> triangles = {};
  std::vector<std::pair<int, int>> lines = {};  ///< from point to point
  std::vector<std::pair<std::string, std::vector<std::int64_t>>> data = {};
};

/// The file, with coordinates in double precision.
std::string vtpText(const VtpSurface& surface);

}  // namespace packmesh
