// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Linear programmes in few variables with many inequalities.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

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
  static constexpr int size = 7;  ///< variables
  using Vector = Eigen::Matrix<double, size, 1>;

  enum class Status {
    optimal,
    infeasible,
    unsolved,  ///< rounding errors: some inequality is violated by more than the tolerance
  };
  struct Solution {
    Status status = Status::unsolved;
    Vector x = Vector::Zero();  ///< when optimal: violates no normalised row by more than the tolerance
    int pivots = 0;
  };

  Vector objective = Vector::Zero(), lower = Vector::Zero(), upper = Vector::Zero();

  /// Removes all rows. @param rows that there is to be room for
  void clear(int rows);
  /// a · x <= b. Pre: finite
  void addRow(const Vector& a, double b);
  int rows() const { return rows_; }

  /// Pre: lower <= upper, all finite
  Solution solve() const;

 private:
  friend class DualSimplex;
  std::array<std::vector<double>, size> column_;  ///< rows of unit length, one array per variable
  std::vector<double> rhs_;
  int rows_ = 0;
  bool contradiction_ = false;  ///< a row without coefficients that is infeasible
};

}  // namespace packmesh
