// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Initial positions in rouleaux: parallel columns of stacked cells.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/core/pose.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

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
