// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The planes behind which cells must stay while they grow, and what makes them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "packMesh/cat/growing_cells.h"
#include "packMesh/core/pose.h"

namespace packmesh {

/// The constraint that a vertex of an object stays behind a plane: normal · (T(vertex) - point) <= 0 (thesis
/// eq. 3.2). Faces of CAT cells become such constraints first; chords are added to CellPlanes at once.
struct PlaneConstraint {
  Vec3 vertex;  ///< body frame [µm]
  Vec3 point;   ///< on the plane, world frame, nearest image [µm]
  Vec3 normal;  ///< unit, away from the object
};

/// The planes of each object.
using PlaneConstraints = std::vector<std::vector<PlaneConstraint>>;

/// The planes of one cell in single precision, relative to its centre: normal · (T(vertex) - centre) <=
/// distance. Rounding, some 1e-7 of the size of the cell, is far below the padding.
class CellPlanes {
 public:
  /// Columns: `arm` is the vertex rotated by the cell's orientation, at scale 1 [µm]; `normal` the unit
  /// vector away from the cell; `distance` that of the plane from the centre [µm].
  static constexpr int arm = 0, normal = 3, distance = 6, columns = 7;
  /// There is room for so many entries beyond the last plane, which kernels may overwrite.
  static constexpr std::size_t spare = 16;

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  void clear() { size_ = 0; }
  const float* column(int k) const { return columns_[k].data(); }

  /// Makes room for `more` planes. @return where each column continues; grow() then says how many were
  /// written
  std::array<float*, columns> room(std::size_t more) {
    const std::size_t needed = size_ + more + spare;
    std::array<float*, columns> out;
    for (int k = 0; k < columns; ++k) {
      if (columns_[k].size() < needed) columns_[k].resize(needed + needed / 2);
      out[k] = columns_[k].data() + size_;
    }
    return out;
  }
  void grow(std::size_t more) { size_ += more; }

  void add(const Vec3& rotatedVertex, const Vec3& away, double toPlane) {
    const std::array<float*, columns> out = room(1);
    for (int k = 0; k < 3; ++k) {
      *out[arm + k] = static_cast<float>(rotatedVertex[k]);
      *out[normal + k] = static_cast<float>(away[k]);
    }
    *out[distance] = static_cast<float>(toPlane);
    grow(1);
  }
  void add(const Pose& pose, const PlaneConstraint& plane) {
    add(pose.orientation.toRotationMatrix() * plane.vertex, plane.normal,
        plane.normal.dot(plane.point - pose.position));
  }

 private:
  std::array<std::vector<float>, columns> columns_;
  std::size_t size_ = 0;
};

/// Request to a plane function.
struct PlaneRequest {
  const CellSurroundings& surroundings;
  std::vector<std::int64_t> wanted;  ///< cells whose planes are requested, ascending
  double detail = 1.0;               ///< fraction of the vertices to be used (eq. 3.4)
  double motion = 0.0;               ///< expected displacement of points in one iteration, growth apart [µm]
  /// Index of this group of cells on this rank. Unless `anew`, the surroundings have the same cells in the
  /// same order as in the previous request, and the same cells are requested.
  std::size_t batch = 0;
  bool anew = true;
  int thread = 0;  ///< that requests
};

/// Constructs, from a state free of overlap, the planes that constrain each cell. Between two cells that both
/// move, planes are at half the gap, so that both may grow up to them simultaneously; fixed cells are
/// approached up to their surface.
class PlaneFunction {
 public:
  virtual ~PlaneFunction() = default;

  /// Called on one thread before each of these requests is made, if they are `anew`: those of all batches.
  virtual void begin(const std::vector<PlaneRequest>& /*requests*/) {}

  /// Adds the planes of each requested cell to planes[0], planes[1] ..., in that order.
  /// Pre: no two cells overlap. Ranks call it independently of each other, and threads, each for batches of
  /// its own.
  virtual void operator()(const PlaneRequest& request, std::vector<CellPlanes>& planes) = 0;

  /// Steps rarely use all their bounds at once. Planes are requested only within this fraction of the largest
  /// displacement; overlaps after steps that went further are removed by step halving.
  virtual double expectedShare() const { return 0.4; }

  /// Number of iterations for which data about the surroundings can be reused.
  virtual std::int64_t lifetime() const { return 1; }

  /// Number of cells per request, at most, if the planes of a cell depend on the others in its request: these
  /// are then parts of blocks, the same ones on any number of ranks; 0: any.
  virtual std::int64_t cellsAtOnce() const { return 0; }
};

}  // namespace packmesh
