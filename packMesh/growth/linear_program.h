// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Linear programmes in few variables with many inequalities.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace packmesh {

/// maximise objective · x subject to a_i · x <= b_i and lower <= x <= upper, in seven variables: scale,
/// rotation and translation of one cell. Variables that are not needed are fixed by equal bounds.
///
/// Method: the dual simplex algorithm with explicit inverse of the 7 x 7 basis. It starts where the bounds
/// are best for the objective; each pivot takes the most violated inequality in (after normalisation), so a
/// programme of hundreds of rows takes some 10-25 pivots, each one pass over the rows. When pivots
/// bring no progress Bland's rule takes over, so degenerate programmes end too.
class LinearProgram {
 public:
  static constexpr int size = 7;  ///< variables
  using Vector = Eigen::Matrix<double, size, 1>;

  enum class Status {
    optimal,
    infeasible,
    unsolved,  ///< rounding won: some inequality is violated by more than the tolerance
  };
  struct Solution {
    Status status = Status::unsolved;
    Vector x = Vector::Zero();  ///< when optimal: violates no normalised row by more than the tolerance
    int pivots = 0;
  };

  Vector objective = Vector::Zero(), lower = Vector::Zero(), upper = Vector::Zero();

  /// Takes all rows out.
  void clear();
  /// a · x <= b. Pre: finite
  void addRow(const Vector& a, double b);
  int rows() const { return static_cast<int>(rhs_.size()); }

  /// Pre: lower <= upper, all finite
  Solution solve() const;

 private:
  friend class DualSimplex;
  std::array<std::vector<double>, size> column_;  ///< rows of unit length, one array per variable
  std::vector<double> rhs_;
  bool contradiction_ = false;  ///< a row without coefficients that cannot hold
};

}  // namespace packmesh
