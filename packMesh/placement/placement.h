// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Random initial positions.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "packMesh/core/pose.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

class AccessibleSpace;

/// Point n of the unit cube: frac(begin + n (1/g, 1/g², 1/g³)) with g⁴ = g + 1, for which any number of
/// successive points is evenly spread (M. Roberts 2018, "The unreasonable effectiveness of quasirandom
/// sequences"), plus an offset.
/// @param begin four uniform numbers, of which three are used
Vec3 evenPoint(const std::array<double, 4>& begin, std::uint64_t n, const Vec3& offset = Vec3::Zero());

/// Number n of [0, 1): successive ones are evenly spread (golden ratio).
double evenShare(double begin, std::uint64_t n);

/// Largest random displacement of such points along each axis, so that seeds differ in more than the
/// beginning of the sequence [cube root of the cell's volume].
constexpr double jitter = 1.0 / 3.0;

/// Orientation from three uniform numbers: uniform, or with a cone the axis uniform over it and the rotation
/// about the axis uniform.
Quaternion randomOrientation(const std::optional<AxisCone>& cone, double u, double v, double w);

/// Random poses of scale 1 of cells of a species, within its freedom: centres uniform over the lumen, but
/// more evenly spread than independent points (and, where there is room, as far from the wall as the smallest
/// half-thickness of the shape); orientations uniform, or the identity without Physics::rotate. Cells
/// overlap. Each pose depends only on the physics, the seed among them, and the cell's id. If interrupted,
/// the remaining cells have default poses.
/// @param shape of the cells
/// @param firstId of `count` cells: numbers over all species
/// @param space of the species: cells start where they do not meet the wall; nullptr: anywhere in the lumen
std::vector<Pose> placeRandomly(const Physics& physics, const Execution& execution, int species, int shape,
                                std::int64_t firstId, std::int64_t count,
                                const AccessibleSpace* space = nullptr);

}  // namespace packmesh
