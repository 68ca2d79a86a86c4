// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Reading mesh files: STL and PLY (as text and binary), OFF and OBJ (as text).
///
/// Files are read by packMesh's own strict readers, in double precision (see mesh_readers.h for the reasons).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Reads the triangles of a mesh file unchanged, except that vertices with equal coordinates are merged in
/// the order of their first appearance; repairs nothing else (see repairClosed). Polygons are divided into
/// triangles. The format is determined by the extension, in upper or lower case. Lengths are as in the file.
/// @param notes receives a line for what is odd about the file, but can be read: a text STL file without
/// 'endsolid', bytes after the last triangle; nullptr: not wanted
/// @throws InputError naming the file, and the line of a text, if it is missing, unreadable, empty, of an
///   unknown format, truncated, malformed, without triangles, or has coordinates that are not finite
TriangleMesh readMesh(const std::filesystem::path& file, std::vector<std::string>* notes = nullptr);

/// The same of a text in OFF format that something else has made of `file`.
TriangleMesh meshInOff(const std::string& content, const std::filesystem::path& file);

}  // namespace packmesh
