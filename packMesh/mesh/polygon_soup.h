// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What stands in a mesh file, before anything is made of it. Internal to packMesh/io.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/core/vector.h"

namespace packmesh {

/// Polygons over vertices exactly as a file lists them: nothing merged, dropped or reordered.
struct PolygonSoup {
  std::vector<Vec3> vertices;
  std::vector<int> corners;  ///< vertex indices of all polygons, one polygon after the other
  std::vector<int> ends;     ///< for each polygon, one past its last corner

  void addPolygon(const std::vector<int>& polygon) {
    corners.insert(corners.end(), polygon.begin(), polygon.end());
    ends.push_back(static_cast<int>(corners.size()));
  }
};

/// Strict readers of text: every coordinate in double precision, every index checked, every error with its
/// line. OpenMesh's readers of these kinds round coordinates to single precision and read past damage in
/// silence (a truncated OFF file becomes triangles 0 0 0), which is why they are not used here.
/// @param content the whole file; @param file its name, for messages
/// @throws InputError naming file and line, what was expected and what was found
PolygonSoup readTextStl(const std::string& content, const std::filesystem::path& file);
PolygonSoup readTextOff(const std::string& content, const std::filesystem::path& file);
PolygonSoup readTextPly(const std::string& content, const std::filesystem::path& file);
PolygonSoup readObj(const std::string& content, const std::filesystem::path& file);

/// Binary STL; `content` has the size its header announces.
PolygonSoup readBinaryStl(const std::string& content);

/// Binary PLY (either byte order, any properties) and binary OFF (Geomview's and OpenMesh's). Strict, too:
/// OpenMesh's reader goes through 10^9 vertices that a header announces and no file holds.
PolygonSoup readBinaryPly(const std::string& content, const std::filesystem::path& file);
PolygonSoup readBinaryOff(const std::string& content, const std::filesystem::path& file);

}  // namespace packmesh
