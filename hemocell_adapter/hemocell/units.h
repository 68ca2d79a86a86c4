// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What users should know when lengths look as if they were in another unit.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "packMesh/container/container.h"
#include "packMesh/core/vector.h"

namespace packmesh::hemocell {

/// A warning for a lattice spacing at which blood cells are not resolved, or far finer than usual; nothing
/// otherwise.
/// @param dx [µm]
/// @param where what set it, for the message
std::optional<std::string> spacingWarning(double dx, const std::string& where);

/// "; if the file is in mm, the factor is 1000" when that makes `extent` lie in [least, most] and it does not
/// as it is, else nothing.
/// @param extent of the mesh with the factor that was given [µm]
/// @param factor that was given [µm per unit of the file]
std::string unitHint(double extent, double factor, double least, double most);

/// Largest extents of vessels and of blood cells that are plausible [µm].
inline constexpr double smallestVessel = 2.0, largestVessel = 2e4;
inline constexpr double smallestCell = 0.5, largestCell = 50.0;

/// A factor for the positions of .pos files with which they would lie in the lumen, and where it may come
/// from.
struct PositionFactor {
  double factor = 1.0;
  std::string cause;
};

/// Such a factor when as they are most of them lie outside, or so near to each other that cells must overlap.
/// @param volumes of the cells [µm³]
/// @param dx lattice spacing of the case [µm]
std::optional<PositionFactor> positionFactor(const Container& container, const std::vector<Vec3>& positions,
                                             double volumes, double dx);

}  // namespace packmesh::hemocell
