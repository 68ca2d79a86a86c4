// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Growth of one cell within its planes (thesis eqs. 3.1-3.3, 3.9, 3.10): linear programmes in seven
/// variables.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "packMesh/cat/growing_cells.h"
#include "packMesh/cat/growth_kernels.h"
#include "packMesh/core/pose.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

/// Maximises objective · x subject to a_i · x <= b_i and lower <= x <= upper, in seven variables: scale,
/// rotation and translation of one cell. Variables that are not needed are fixed by equal bounds.
///
/// Method: the dual simplex algorithm with explicit inverse of the 7 x 7 basis. It starts where the bounds
/// are best for the objective; in each pivot the most violated inequality (after normalisation) enters, so
/// that a programme of hundreds of rows takes some 10-25 pivots, each one pass over the rows. If pivots make
/// no progress, Bland's rule is used, so that degenerate programmes terminate too.
class LinearProgram {
 public:
  static constexpr int size = LinearProgramView::size;  ///< variables
  using Vector = Vec<double, size>;

  using Status = LinearProgramStatus;
  struct Solution {
    Status status = Status::unsolved;
    Vector x = Vector::Zero();  ///< when optimal: violates no normalised row by more than the accuracy
    int pivots = 0;
  };

  Vector objective = Vector::Zero(), lower = Vector::Zero(), upper = Vector::Zero();
  double accuracy = tolerance::linearProgram;  ///< for variables and normalised rows of order 1

  void clear();  ///< Removes all rows.
  /// a · x <= b. Pre: finite
  void addRow(const Vector& a, double b);
  /// Makes room for `more` rows of unit length, and as many as are done at once. @return where the columns
  /// and the right-hand sides continue; grow() then says how many were written
  std::array<double*, size + 1> room(int more);
  void grow(int more);
  int rows() const { return rows_; }

  /// Pre: lower <= upper, all finite
  Solution solve() const;

 private:
  void reserve(int rows);
  void fillUp();

  std::array<std::vector<double>, size + 1>
      column_;  ///< of rows of unit length: coefficients, right-hand side
  int rows_ = 0;
  bool contradiction_ = false;  ///< a row without coefficients that is infeasible
  LinearProgramKernel kernel_ = linearProgramKernel(chosenInstructionSet());
};

/// Change of a pose. The rotation is the axis times twice the tangent of half the angle, so that poses need
/// no trigonometric functions; for small angles it is the rotation vector [rad].
struct GrowthStep {
  double scale = 1.0;  ///< at the end of the step
  Vec3 rotation = Vec3::Zero();
  Vec3 translation = Vec3::Zero();  ///< [µm]
};

/// `pose` after a fraction of a step; exactly `pose` for 0.
/// @param cone constraint on the cell's axis; nullptr: none
Pose stepped(const Pose& pose, const GrowthStep& step, double fraction = 1.0, const AxisCone* cone = nullptr);

/// Bounds of a step (eq. 3.3), and parameters of its optimisation.
struct GrowthBounds {
  double scale = 1.0;        ///< the barrier: largest scale; not less than the pose's
  double rotation = 0.0;     ///< θ_max about each axis [rad]
  double translation = 0.0;  ///< t_max along each axis [µm]
  double padding = 0.0;      ///< p of eq. 3.10 [µm]
  int linearisations = 1;
  /// Cells that can reach the barrier are moved until their planes are at least this much further away than
  /// the padding, or as far as possible [µm]; 0: they stay where they can reach it.
  double margin = 0.0;
  /// Allowed directions of the cell's axis, including that of the pose. Empty: all.
  std::optional<AxisCone> cone;
  /// Objective of the rotation and translation, small compared to 1, the coefficient of the scale: selects
  /// one of several equally good steps.
  Vec3 turn = Vec3::Zero(), push = Vec3::Zero();
};

/// Sequential linear programming: the rotation is linearised, the programme of seven variables solved, and
/// again around its solution. A plane that is nearer than the padding keeps its distance, so that the zero
/// step is always feasible.
class GrowthProgram {
 public:
  /// Largest scale within the planes, never less than the pose's; at the barrier, largest distance from them.
  /// Without planes the cell grows to the barrier at its position.
  GrowthStep solve(const Pose& pose, const CellPlanes& planes, const GrowthBounds& bounds);

  int pivots() const { return pivots_; }  ///< of all programmes so far

 private:
  void takeReached(const Pose& pose, const CellPlanes& planes, const GrowthBounds& bounds);
  bool improve(const GrowthBounds& bounds, bool atBarrier, GrowthStep& step);
  void addCone(const AxisCone& cone, const Mat3& rotation);

  CellPlanes reached_;  ///< planes that a step within the bounds could reach, with limits as distances
  float room_ = 0.0f;   ///< least distance of any vertex from its limit at the largest scale [µm]
  GrowthRowKernel kernel_ = growthRowKernel(chosenInstructionSet());
  Vec3 axis_ = Vec3::UnitY();  ///< of the cell, initially
  LinearProgram program_;
  int pivots_ = 0;
};

}  // namespace packmesh
