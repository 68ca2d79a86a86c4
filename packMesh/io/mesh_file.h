// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Reading and writing mesh files (STL ascii and binary, OFF, PLY, OBJ), by OpenMesh.
#pragma once

#include <filesystem>

#include "packMesh/geometry/triangle_mesh.h"

namespace packmesh {

/// Reads the triangles of a mesh file as they are, vertices of equal coordinates merged in the order of their
/// first appearance; repairs nothing else (see repairClosed). Polygons are cut into triangles.
/// @throws InputError when the file is missing, unreadable, empty, of an unknown kind, or garbage
TriangleMesh readMesh(const std::filesystem::path& file);

/// Writes `mesh` with round-trip precision where the format allows it; the kind follows the ending.
/// @throws InputError when the file cannot be written
void writeMesh(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace packmesh
