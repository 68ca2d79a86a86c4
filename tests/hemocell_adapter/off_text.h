// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A plain reader of OFF files for tests: independent of the library's, keeps every digit and the
/// order.
#pragma once

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include "packMesh/mesh/triangle_mesh.h"

inline packmesh::TriangleMesh readOffText(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot read " + file);
  std::stringstream text;
  for (std::string line; std::getline(in, line);)
    if (line.empty() || line[0] != '#') text << line << '\n';
  std::string head;
  int vertices = 0, triangles = 0, edges = 0;
  text >> head >> vertices >> triangles >> edges;
  packmesh::TriangleMesh mesh;
  mesh.vertices.resize(vertices);
  mesh.triangles.resize(triangles);
  for (packmesh::Vec3& v : mesh.vertices) text >> v.x() >> v.y() >> v.z();
  for (packmesh::Triangle& t : mesh.triangles) {
    int corners = 0;
    text >> corners >> t[0] >> t[1] >> t[2];
  }
  if (!text || head != "OFF") throw std::runtime_error("not a triangle OFF file: " + file);
  return mesh;
}
