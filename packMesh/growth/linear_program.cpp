// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/linear_program.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "packMesh/core/tolerances.h"

namespace packmesh {
namespace {

constexpr int size = LinearProgram::size;
using Vector = LinearProgram::Vector;
using Matrix = Eigen::Matrix<double, size, size>;

/// Number of pivots after which the inverse is recomputed.
constexpr int pivotsPerInverse = 30;

/// Number of pivots without progress after which Bland's rule is used.
constexpr int patience = 3 * size;

}  // namespace

/// One run of the algorithm. Constraints are numbered: rows, then upper bounds, then lower bounds.
class DualSimplex {
 public:
  explicit DualSimplex(const LinearProgram& program) : p_(program), rows_(program.rows()) {
    violation_.resize(rows_);
    for (int j = 0; j < size; ++j) {
      basis_[j] = rows_ + (p_.objective[j] > 0.0 ? j : size + j);
    }
  }

  LinearProgram::Solution operator()() {
    LinearProgram::Solution solution;
    invert();
    int sinceInverse = 0, sinceProgress = 0;
    const int most = 1000 + 20 * rows_;
    while (solution.pivots < most) {
      const int entering = findViolated(sinceProgress > patience);
      if (entering < 0) {
        if (sinceInverse > 0) {  // accumulated rounding errors must not decide
          invert();
          sinceInverse = 0;
          continue;
        }
        solution.status = LinearProgram::Status::optimal;
        solution.x = x_;
        return solution;
      }
      const Vector alpha = columns_.transpose() * coefficients(entering);
      const int leaving = findLeaving(alpha, sinceProgress > patience);
      if (leaving < 0) {
        if (sinceInverse > 0) {
          invert();
          sinceInverse = 0;
          continue;
        }
        solution.status = LinearProgram::Status::infeasible;
        return solution;
      }
      const double step = price_[leaving] / alpha[leaving];
      sinceProgress = step > tolerance::linearProgram ? 0 : sinceProgress + 1;
      pivot(entering, leaving, alpha);
      ++solution.pivots;
      if (++sinceInverse >= pivotsPerInverse) {
        invert();
        sinceInverse = 0;
      }
    }
    return solution;
  }

 private:
  Vector coefficients(int constraint) const {
    Vector a;
    if (constraint < rows_) {
      for (int j = 0; j < size; ++j) a[j] = p_.column_[j][constraint];
    } else {
      a.setZero();
      const int bound = constraint - rows_;
      a[bound % size] = bound < size ? 1.0 : -1.0;
    }
    return a;
  }

  double rhs(int constraint) const {
    if (constraint < rows_) return p_.rhs_[constraint];
    const int bound = constraint - rows_, j = bound % size;
    return bound < size ? p_.upper[j] : -p_.lower[j];
  }

  /// Inverse, solution and prices of the basis.
  void invert() {
    Matrix b;
    for (int i = 0; i < size; ++i) b.row(i) = coefficients(basis_[i]);
    columns_ = b.partialPivLu().inverse();
    x_.setZero();
    for (int i = 0; i < size; ++i) x_ += rhs(basis_[i]) * columns_.col(i);
    price_ = (columns_.transpose() * p_.objective).cwiseMax(0.0);
  }

  void findViolationsOfRows() {
    double* v = violation_.data();
    const double *a0 = p_.column_[0].data(), *a1 = p_.column_[1].data(), *a2 = p_.column_[2].data(),
                 *a3 = p_.column_[3].data(), *a4 = p_.column_[4].data(), *a5 = p_.column_[5].data(),
                 *a6 = p_.column_[6].data(), *b = p_.rhs_.data();
    for (int i = 0; i < rows_; ++i)
      v[i] = a0[i] * x_[0] + a1[i] * x_[1] + a2[i] * x_[2] + a3[i] * x_[3] + a4[i] * x_[4] + a5[i] * x_[5] +
             a6[i] * x_[6] - b[i];
  }

  /// The most violated constraint, or with `first` the first one; -1: none. The violation is stored in
  /// `excess_`.
  int findViolated(bool first) {
    findViolationsOfRows();
    excess_ = tolerance::linearProgram * (1.0 + x_.cwiseAbs().maxCoeff());
    int found = -1;
    for (int i = 0; i < rows_; ++i)
      if (violation_[i] > excess_) {
        excess_ = violation_[i];
        found = i;
        if (first) return found;
      }
    for (int bound = 0; bound < 2 * size; ++bound) {
      const double x = x_[bound % size];
      const double violation = (bound < size ? x : -x) - rhs(rows_ + bound);
      if (violation > excess_) {
        excess_ = violation;
        found = rows_ + bound;
        if (first) return found;
      }
    }
    return found;
  }

  /// The constraint that leaves the basis, so that all prices stay positive; -1: none.
  int findLeaving(const Vector& alpha, bool bland) const {
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < size; ++i)
      if (alpha[i] > tolerance::linearProgram) least = std::min(least, price_[i] / alpha[i]);
    if (std::isinf(least)) return -1;
    const double tie = least + 1e-3 * tolerance::linearProgram * (1.0 + least);
    int leaving = -1;
    for (int i = 0; i < size; ++i) {
      if (!(alpha[i] > tolerance::linearProgram) || price_[i] / alpha[i] > tie) continue;
      if (leaving < 0 || (bland ? basis_[i] < basis_[leaving] : alpha[i] > alpha[leaving])) leaving = i;
    }
    return leaving;
  }

  void pivot(int entering, int leaving, const Vector& alpha) {
    columns_.col(leaving) /= alpha[leaving];
    const double price = price_[leaving] / alpha[leaving];
    for (int i = 0; i < size; ++i) {
      if (i == leaving) continue;
      columns_.col(i) -= alpha[i] * columns_.col(leaving);
      price_[i] = std::max(0.0, price_[i] - alpha[i] * price);
    }
    price_[leaving] = price;
    x_ -= excess_ * columns_.col(leaving);
    basis_[leaving] = entering;
  }

  const LinearProgram& p_;
  int rows_;
  int basis_[size];
  Matrix columns_;  ///< of the inverse: direction in which x moves when a constraint of the basis is relaxed
  Vector x_;        ///< the basic solution
  Vector price_;    ///< of the constraints of the basis, >= 0
  double excess_ = 0.0;            ///< of the constraint that findViolated() found
  std::vector<double> violation_;  ///< of rows
};

void LinearProgram::clear(int rows) {
  for (std::vector<double>& column : column_)
    if (column.size() < static_cast<std::size_t>(rows)) column.resize(rows);
  if (rhs_.size() < static_cast<std::size_t>(rows)) rhs_.resize(rows);
  rows_ = 0;
  contradiction_ = false;
}

void LinearProgram::addRow(const Vector& a, double b) {
  const double square = a.squaredNorm();
  if (!(square > 0.0)) {
    contradiction_ = contradiction_ || b < -tolerance::linearProgram;
    return;
  }
  if (static_cast<std::size_t>(rows_) == rhs_.size()) {
    for (std::vector<double>& column : column_) column.push_back(0.0);
    rhs_.push_back(0.0);
  }
  const double scale = 1.0 / std::sqrt(square);
  for (int j = 0; j < size; ++j) column_[j][rows_] = scale * a[j];
  rhs_[rows_] = scale * b;
  ++rows_;
}

LinearProgram::Solution LinearProgram::solve() const {
  if (contradiction_) {
    Solution solution;
    solution.status = Status::infeasible;
    return solution;
  }
  return DualSimplex(*this)();
}

}  // namespace packmesh
