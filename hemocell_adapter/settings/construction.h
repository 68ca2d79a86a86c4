// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What users call the ways in which a template mesh is made.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace packmesh::hemocell {

/// How HemoCell constructs the template; named in the case's C++ code, so in our configuration too.
enum class Construction { rbcFromSphere, ellipsoidFromSphere, wbcSphere, meshFromStl };

/// `RBC_FROM_SPHERE`, `ELLIPSOID_FROM_SPHERE`, `WBC_SPHERE`, `MESH_FROM_STL`.
std::string toString(Construction construction);
std::optional<Construction> constructionFromString(const std::string& text);
/// All of them.
std::vector<std::string> constructionNames();

/// How a mesh file without `<Cell>.xml` becomes a cell: by MESH_FROM_STL, or with the axes of the file.
enum class MeshFrame { hemocell, file };

/// `hemocell`, `file`.
std::vector<std::string> meshFrameNames();
std::optional<MeshFrame> meshFrameFromString(const std::string& text);

}  // namespace packmesh::hemocell
