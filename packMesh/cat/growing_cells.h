// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells while they grow: on which rank they are, and which of them are near to each other.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "packMesh/core/pose.h"
#include "packMesh/mesh/neighbor_search.h"
#include "packMesh/parallel/blocks.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"
#include "packMesh/relaxation/body.h"
#include "packMesh/relaxation/shared_bodies.h"

namespace packmesh {

/// Whether a cell stays where it is, with its scale.
inline bool isFixed(const Physics& physics, const Body& cell) {
  return cell.frozen || physics.species[cell.species].freedom.fixed;
}

/// Every cell belongs to the rank that owns its block; each rank has copies (ghosts) of the cells within a
/// range of its own. The memory of a rank does not grow with the total number of cells, except for one number
/// per block, of which there are at most some 30 000.
///
/// All ranks call distribute(), replace(), add() and updateGhosts() together.
class GrowingCells {
 public:
  /// References `physics` and `execution`, which must outlive it.
  /// @param own each cell on exactly one rank, no matter which
  /// @param range distance within which cells affect each other [µm]
  /// @param cellsPerBlock target; 0: blocks are as small as the range allows
  /// @param leastEdge of blocks [µm], if that is more than the range
  GrowingCells(const Physics& physics, const Execution& execution, std::vector<Body> own, double range,
               std::int64_t cellsPerBlock, double leastEdge = 0.0);

  /// Moves every cell to the owner of its block, and updates the ghosts. Sorts by block, then by id.
  void distribute();
  /// Replaces the cells by others (or the same ones at other positions). @param own each on one rank
  void replace(std::vector<Body> own);
  /// Adds cells, each on one rank, with new ids. Call distribute() afterwards.
  void add(const std::vector<Body>& own);
  /// Ghosts receive the changes made by their owners (Body::changed); they are then marked as `touched`.
  void updateGhosts();

  /// This rank's cells and ghosts.
  std::vector<Body>& all() { return bodies_; }
  const std::vector<Body>& all() const { return bodies_; }
  bool isOwn(std::int64_t cell) const { return own_[cell]; }
  const std::vector<bool>& ownFlags() const { return own_; }
  std::int64_t count() const { return count_; }  ///< on all ranks

  /// This rank's cells, sorted by id.
  std::vector<Body> own() const;

  /// This rank's cells (indices, ascending) in groups of neighbouring cells: those of several blocks, up to
  /// about `most` cells in total, or of one block each if `most` is 0.
  std::vector<std::vector<std::int64_t>> batches(std::size_t most) const;
  /// The same in groups of at most `most` cells: blocks with more are divided into compact parts of about
  /// equal numbers. They are the same on any number of ranks. Pre: distributed since cells moved
  std::vector<std::vector<std::int64_t>> partsOfBlocks(std::size_t most) const;

  /// A block of this rank.
  struct Block {
    int number;
    std::vector<std::int64_t> cells, around;  ///< its cells; the others within the range of it. By id
  };
  /// This rank's blocks of one colour, those without cells too, along the space-filling curve. The same
  /// blocks on any number of ranks, with the same cells.
  std::vector<Block> blocksOf(int colour) const;
  /// This rank's blocks; those of all ranks together are in order along the space-filling curve.
  std::vector<int> ownBlocks() const;
  const BlockGrid& grid() const { return blocks_; }

  /// Adds the cost of a cell in the last iteration, in any unit, for load balancing.
  void addWork(std::int64_t cell, std::int64_t work) { work_[bodies_[cell].block] += work; }

 private:
  void balance();

  const Physics& physics_;
  const Execution& execution_;
  double range_;
  BlockGrid blocks_;
  SharedBodies shared_;
  std::int64_t count_;
  std::vector<Body> bodies_;
  std::vector<bool> own_;
  std::vector<std::int64_t> work_;  ///< per block, since the last distribution of the blocks
};

/// Cells of one rank, including ghosts, and how far each may move in the step for which planes are requested.
/// Sorted so that any two cells are in the same order on every rank that has both.
class CellSurroundings {
 public:
  /// References `physics` and `cells`, which must outlive it; neighbours remain those of the present cells.
  /// @param reach upper bound of the displacement of any point of each cell for which planes are made [µm]
  /// @param extent radius of a sphere around the centre that contains each cell after its step [µm]
  CellSurroundings(const Physics& physics, const std::vector<Body>& cells, std::vector<double> reach,
                   std::vector<double> extent);

  const std::vector<Body>& cells() const { return cells_; }
  double reach(std::int64_t cell) const { return reach_[cell]; }
  /// Pairs of cells (or periodic images), at least one of them in `wanted` (ascending), that can come within
  /// the clearance of each other; each once, in an order that does not depend on the rank.
  std::vector<NearPair> pairsOf(const std::vector<std::int64_t>& wanted) const;

  /// Whether a cell can come within the clearance of one that is marked.
  bool isNear(std::int64_t cell, const std::vector<char>& marked) const;

  /// Of spheres that contain the cells before and after their steps.
  const PeriodicNeighbors& neighbors() const { return neighbors_; }

 private:
  /// Calls visit(pair) for pairs with wanted(other) that can come within the clearance.
  template <class Wanted, class Visit>
  void forEachNear(std::int64_t cell, const Wanted& wanted, const Visit& visit) const;

  const std::vector<Body>& cells_;
  std::vector<double> reach_;
  std::vector<double> beyond_;  ///< by which the spheres are larger than planes require [µm]
  double clearance_;
  PeriodicNeighbors neighbors_;
};

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
