// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The contents of a mesh file before processing. Internal to packMesh/mesh.
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

  std::vector<std::string> notes;  ///< what is odd about the file, and how it was read

  void addPolygon(const std::vector<int>& polygon) {
    corners.insert(corners.end(), polygon.begin(), polygon.end());
    ends.push_back(static_cast<int>(corners.size()));
  }
  int largestCorner() const {
    return corners.empty() ? -1 : *std::max_element(corners.begin(), corners.end());
  }
};

/// Strict readers of text and binary files: every coordinate in double precision, every count checked against
/// the file before it is used, no face skipped, every error in a text reported with its line. OpenMesh's
/// readers would need less code, but round coordinates to single precision, skip faces, and accept damaged
/// files or do not terminate on them (docs/contributing.md). Corners may refer to vertices that do not exist:
/// readMesh() checks them.
/// @param content the whole file; @param file its name, for messages
/// @throws InputError naming the file, the line of a text, what was expected and what was found
PolygonSoup readStl(const std::string& content, const std::filesystem::path& file);
PolygonSoup readObj(const std::string& content, const std::filesystem::path& file);
PolygonSoup readPly(const std::string& content, const std::filesystem::path& file);
PolygonSoup readOff(const std::string& content, const std::filesystem::path& file);

}  // namespace packmesh
