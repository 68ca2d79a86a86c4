// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Bodies described by a user: lumens, obstacles and regions.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/job.h"
#include "packMesh/container/container.h"

namespace packmesh::hemocell {

/// Spacing at which the distances of vessels are sampled [µm]: fine enough for a wall clearance of some
/// hundredths of a micrometre on smooth walls.
inline constexpr double vesselDetail = 0.5;

/// A closed surface; what was repaired is added to `notices`.
/// @param asRead if given, receives the mesh without repairs. @throws InputError that begins with `where`
TriangleMesh readClosed(const std::filesystem::path& file, const std::string& where,
                        std::vector<std::string>& notices, TriangleMesh* asRead = nullptr);

/// A body as a separate container.
/// @param periodic axes along which it is periodic
std::shared_ptr<const Container> makeSolid(const SolidRequest& solid, const std::array<bool, 3>& periodic,
                                           std::vector<std::string>& notices);

}  // namespace packmesh::hemocell
