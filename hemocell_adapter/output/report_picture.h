// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The picture in a report.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace packmesh::hemocell {

struct Picture {
  std::string png;   ///< bytes; empty: none
  std::string note;  ///< otherwise: why not, and how to get one
};

/// Renders a scene with POV-Ray, if `povray` is in PATH, in a folder of its own that is gone afterwards.
/// @param writeScene writes the scene to the file it is given
Picture renderPicture(const std::function<void(const std::filesystem::path&)>& writeScene);

}  // namespace packmesh::hemocell
