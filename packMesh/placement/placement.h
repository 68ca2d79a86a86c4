// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Initial positions: random, and in rouleaux, parallel columns of stacked cells.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/core/pose.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"
#include "packMesh/shape/shape.h"

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

/// Whether a cell of full size in this orientation meets none of its own periodic images: always, if no
/// period is shorter than the cell.
bool isClearOfItself(const Physics& physics, const Shape& shape, const Quaternion& orientation);

/// Random poses of scale 1 of cells of a species, within its freedom: centres uniform over the lumen, but
/// more evenly spread than independent points (and, where there is room, as far from the wall as the smallest
/// half-thickness of the shape); orientations uniform among those clear of themselves, or the identity
/// without Physics::rotate. Cells overlap. Each pose depends only on the physics, the seed among them, and
/// the cell's id. If interrupted, the remaining cells have default poses.
/// @param shape of the cells
/// @param firstId of `count` cells: numbers over all species
/// @param space of the species: cells start where they do not meet the wall; nullptr: anywhere in the lumen
std::vector<Pose> placeRandomly(const Physics& physics, const Execution& execution, int species, int shape,
                                std::int64_t firstId, std::int64_t count,
                                const AccessibleSpace* space = nullptr);

/// Columns of cells in a periodic box, the densest order of discs: parallel columns on a plane lattice that
/// is as nearly hexagonal as the box permits. Columns need not be parallel to an edge of the box: one that
/// leaves through a face and returns through the opposite one closes after some periods of each edge, so that
/// nearly every number of cells has an arrangement close to the optimum.
///
/// A cell is represented by the bounding cylinder about the shortest edge of its bounding box.
class Columns {
 public:
  /// Selects, from the arrangements of `count` cells that are tried, the one with most room between cells.
  /// @param gap desired gap between cells [µm]
  /// Pre: count > 0; the box is periodic along all axes
  Columns(const Shape& shape, std::int64_t count, const Box& box, double gap, std::uint64_t seed);

  /// Distance between cells divided by the desired one, along or across the columns, whichever is smaller: if
  /// at least 1, no two cells are closer than the gap.
  double room() const { return room_; }
  std::int64_t columnCount() const { return static_cast<std::int64_t>(feet_.size()); }

  /// Pose of cell 0 ... count - 1. The starts of the columns and the rotation of cells about them depend on
  /// the seed.
  Pose pose(std::int64_t cell) const;

 private:
  Box box_;
  std::uint64_t seed_;
  std::int64_t count_;
  double room_ = 0.0;
  Vec3 along_ = Vec3::UnitX();  ///< unit vector along the columns
  double length_ = 0.0;         ///< length of a column until it closes [µm]
  std::vector<Vec3> feet_;      ///< of the columns, in a plane perpendicular to them [µm]
  Vec3 axis_, middle_;          ///< of the cell's cylinder, in its body frame
};

}  // namespace packmesh
