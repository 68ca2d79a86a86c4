// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Reading and writing mesh files: STL, OFF, PLY (each as text and binary) and OBJ.
///
/// Read by strict readers of our own, in double precision (see polygon_soup.h for why).
#pragma once

#include <filesystem>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Reads the triangles of a mesh file as they are, vertices of equal coordinates merged in the order of their
/// first appearance; repairs nothing else (see repairClosed). Polygons are cut into triangles. The kind
/// follows the ending, in upper or lower case. Lengths are as in the file.
/// @throws InputError naming the file, and the line of a text, when it is missing, unreadable, empty, of an
///   unknown kind, truncated, garbage, without triangles, or has coordinates that are not finite
TriangleMesh readMesh(const std::filesystem::path& file);

/// Writes `mesh` as text that reads back to the same numbers; the kind follows the ending.
/// @throws OutputError when the file cannot be written
void writeMesh(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace packmesh
