// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Names of the ways to construct a template mesh.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace packmesh::hemocell {

/// How HemoCell constructs the template; named as in the case's C++ code.
enum class Construction { rbcFromSphere, ellipsoidFromSphere, wbcSphere, meshFromStl };

/// `RBC_FROM_SPHERE`, `ELLIPSOID_FROM_SPHERE`, `WBC_SPHERE`, `MESH_FROM_STL`.
std::string toString(Construction construction);
std::optional<Construction> constructionFromString(const std::string& text);
/// All names.
std::vector<std::string> constructionNames();

/// Axes of a mesh file without `<Cell>.xml`: rotated as by MESH_FROM_STL, or as in the file.
enum class MeshFrame { hemocell, file };

/// `hemocell`, `file`.
std::string toString(MeshFrame frame);
std::vector<std::string> meshFrameNames();
std::optional<MeshFrame> meshFrameFromString(const std::string& text);

}  // namespace packmesh::hemocell
