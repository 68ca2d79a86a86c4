// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Detection of wrong units of length.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "packMesh/container/container.h"
#include "packMesh/core/vector.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// A warning about a lattice spacing that does not resolve blood cells or is much finer than usual; empty
/// otherwise.
/// @param dx [µm]
/// @param where origin of the value, for the message
std::optional<std::string> spacingWarning(double dx, const std::string& where);

/// "; if the file is in mm, the factor is 1000, if it is in cm, the factor is 10000": units with which
/// `extent` would be in [least, most]; empty if there is none or `extent` is already in the range.
/// @param extent of the mesh with the given factor [µm]
/// @param factor the given factor [µm per unit of the file]
std::string unitHint(double extent, double factor, double least, double most);

/// Whether `factor` [µm per unit of a file] is that of m, cm, mm, µm or nm, up to a relative error.
bool isUnit(double factor, double error);

/// Plausible range of extents of vessels and of blood cells [µm].
inline constexpr double smallestVessel = 2.0, largestVessel = 2e4;
inline constexpr double smallestCell = 0.5, largestCell = 50.0;

/// A factor for the positions of .pos files with which they would lie in the lumen, and its possible origin.
struct PositionFactor {
  double factor = 1.0;
  std::string cause;
};

/// Suggests such a factor if most positions lie outside, or so close to each other that cells must overlap.
/// The result is the same on all ranks, which all call.
/// @param positions of this rank's cells [µm]
/// @param volumes total volume of the cells [µm³]
/// @param dx lattice spacing of the case [µm]
std::optional<PositionFactor> positionFactor(const Container& container, const std::vector<Vec3>& positions,
                                             double volumes, double dx,
                                             const Communicator& ranks = Communicator());

}  // namespace packmesh::hemocell
