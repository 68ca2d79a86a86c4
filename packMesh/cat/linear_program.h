// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Linear programmes in few variables with many inequalities.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "packMesh/core/tolerances.h"
#include "packMesh/cat/linear_program_kernel.h"

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
  using Vector = Eigen::Matrix<double, size, 1>;

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

}  // namespace packmesh
