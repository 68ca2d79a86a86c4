// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What stands in a mesh file, before anything is made of it. Internal to packMesh/mesh.
#pragma once

#include <algorithm>
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
  int largestCorner() const {
    return corners.empty() ? -1 : *std::max_element(corners.begin(), corners.end());
  }
};

/// Strict readers of text and binary files: every coordinate in double precision, every count held against
/// the file before it is believed, no face left out, every error of a text with its line. OpenMesh's readers
/// would be less code, but round coordinates to single precision, leave out faces, and accept damaged files
/// or never end with them (docs/contributing.md).
/// Corners may be numbers of vertices that there are not: readMesh() checks them.
/// @param content the whole file; @param file its name, for messages
/// @throws InputError naming the file, and the line of a text, what was expected and what was found
PolygonSoup readStl(const std::string& content, const std::filesystem::path& file);
PolygonSoup readObj(const std::string& content, const std::filesystem::path& file);
PolygonSoup readPly(const std::string& content, const std::filesystem::path& file);
PolygonSoup readOff(const std::string& content, const std::filesystem::path& file);

}  // namespace packmesh
