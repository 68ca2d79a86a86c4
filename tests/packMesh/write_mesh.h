// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Mesh files for tests.
#pragma once

#include <filesystem>
#include <fstream>
#include <iomanip>
#include <limits>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh::test {

/// Writes `mesh` as text that reads back to the same numbers; the extension (.stl, .off, .ply or .obj, in
/// upper or lower case) determines the format.
inline void writeMesh(const std::filesystem::path& file, const TriangleMesh& mesh) {
  const char kind = char(file.extension().string().at(2) | 0x20);  // t, f, l or b
  std::ofstream out(file, std::ios::binary);
  out.imbue(std::locale::classic());
  out << std::setprecision(std::numeric_limits<double>::max_digits10);
  const auto point = [&](const char* before, const Vec3& v) {
    out << before << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
  };
  if (kind == 't') {
    out << "solid packMesh\n";
    for (const Triangle& t : mesh.triangles) {
      out << "facet normal 0 0 0\nouter loop\n";
      for (const int v : t) point("vertex ", mesh.vertices[v]);
      out << "endloop\nendfacet\n";
    }
    out << "endsolid packMesh\n";
    return;
  }
  if (kind == 'f')
    out << "OFF\n" << mesh.vertices.size() << ' ' << mesh.triangles.size() << " 0\n";
  else if (kind == 'l')
    out << "ply\nformat ascii 1.0\nelement vertex " << mesh.vertices.size()
        << "\nproperty double x\nproperty double y\nproperty double z\nelement face " << mesh.triangles.size()
        << "\nproperty list uchar int vertex_indices\nend_header\n";
  const bool obj = kind == 'b';
  for (const Vec3& v : mesh.vertices) point(obj ? "v " : "", v);
  for (const Triangle& t : mesh.triangles)
    out << (obj ? "f " : "3 ") << t[0] + obj << ' ' << t[1] + obj << ' ' << t[2] + obj << '\n';
}

}  // namespace packmesh::test
