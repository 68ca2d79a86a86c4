// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A mesh and its name.
#pragma once

#include <string>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// A mesh and its name.
struct NamedMesh {
  std::string name;
  TriangleMesh mesh;
};

}  // namespace packmesh
