// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells that start in order: in columns, like rolls of coins.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/core/pose.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// Columns of cells in a periodic box, the densest order of discs: all columns are parallel and stand on a
/// plane lattice, as nearly hexagonal as the box allows. They need not run along an edge of the box: one that
/// leaves it through one face and comes back through the opposite one closes after some periods of each edge,
/// so that nearly any number of cells has an arrangement close to the best there is.
///
/// A cell counts as the cylinder about the shortest edge of its bounding box that holds it.
class Columns {
 public:
  /// Of the arrangements of `count` cells that are tried the one that leaves most room between them.
  /// @param gap wanted between cells [µm]
  /// Pre: count > 0; the box is periodic along all axes
  Columns(const Shape& shape, std::int64_t count, const Box& box, double gap, std::uint64_t seed);

  /// Distances between cells as multiples of those wanted, the smaller one of those along and across the
  /// columns: when at least 1, no cells are nearer to each other than the gap.
  double room() const { return room_; }
  std::int64_t columnCount() const { return static_cast<std::int64_t>(feet_.size()); }

  /// Of cell `cell` of 0 to count - 1. Where columns begin, and how cells are turned about them, depends on
  /// the seed.
  Pose pose(std::int64_t cell) const;

 private:
  Box box_;
  std::uint64_t seed_;
  std::int64_t count_;
  double room_ = 0.0;
  Vec3 along_ = Vec3::UnitX();  ///< unit
  double length_ = 0.0;         ///< of a column until it closes [µm]
  std::vector<Vec3> feet_;      ///< of the columns, in a plane across them [µm]
  Vec3 axis_, middle_;          ///< of the cell's cylinder, in its body frame
};

}  // namespace packmesh
