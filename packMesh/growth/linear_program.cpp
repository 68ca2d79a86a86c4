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

/// Pivots after which the inverse is computed anew.
constexpr int pivotsPerInverse = 30;

/// Pivots without progress after which Bland's rule takes over.
constexpr int patience = 3 * size;

}  // namespace

/// One run of the algorithm. Constraints are numbered: rows, then upper bounds, then lower bounds.
class DualSimplex {
 public:
  explicit DualSimplex(const LinearProgram& program) : p_(program), rows_(program.rows()) {
    violation_.resize(rows_);
    for (int j = 0; j < size; ++j) {
      const bool up = p_.objective[j] > 0.0 || (p_.objective[j] == 0.0 && std::isinf(p_.lower[j]));
      basis_[j] = rows_ + (up ? j : size + j);
      symbolic_ = symbolic_ || std::isinf(p_.upper[j]) || std::isinf(p_.lower[j]);
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
        if (sinceInverse > 0) {  // the verdict is not to rest on accumulated rounding
          invert();
          sinceInverse = 0;
          continue;
        }
        return finished(solution);
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

  /// Right-hand side: a number, plus a multiple of the symbol where a bound is infinite.
  struct Rhs {
    double number, symbol;
  };
  Rhs rhs(int constraint) const {
    if (constraint < rows_) return {p_.rhs_[constraint], 0.0};
    const int bound = constraint - rows_, j = bound % size;
    const double b = bound < size ? p_.upper[j] : -p_.lower[j];
    return std::isinf(b) ? Rhs{0.0, 1.0} : Rhs{b, 0.0};
  }

  /// Inverse, solution and prices of the basis.
  void invert() {
    Matrix b;
    for (int i = 0; i < size; ++i) b.row(i) = coefficients(basis_[i]);
    columns_ = b.partialPivLu().inverse();
    x_.setZero();
    ray_.setZero();
    for (int i = 0; i < size; ++i) {
      const Rhs r = rhs(basis_[i]);
      x_ += r.number * columns_.col(i);
      ray_ += r.symbol * columns_.col(i);
    }
    price_ = (columns_.transpose() * p_.objective).cwiseMax(0.0);
  }

  void violationsOf(const Vector& x, double rhsFactor) {
    double* v = violation_.data();
    const double *a0 = p_.column_[0].data(), *a1 = p_.column_[1].data(), *a2 = p_.column_[2].data(),
                 *a3 = p_.column_[3].data(), *a4 = p_.column_[4].data(), *a5 = p_.column_[5].data(),
                 *a6 = p_.column_[6].data(), *b = p_.rhs_.data();
    for (int i = 0; i < rows_; ++i)
      v[i] = a0[i] * x[0] + a1[i] * x[1] + a2[i] * x[2] + a3[i] * x[3] + a4[i] * x[4] + a5[i] * x[5] +
             a6[i] * x[6] - rhsFactor * b[i];
  }

  /// The most violated constraint, or with `first` the first one; -1: none. Its violation is in `growth_`
  /// (multiple of the symbol) and `excess_`.
  int findViolated(bool first) {
    int found = -1;
    growth_ = excess_ = 0.0;
    const bool withSymbol = symbolic_ && !ray_.isZero(0.0);
    if (withSymbol) {
      violationsOf(ray_, 0.0);
      rayViolation_ = violation_;
    }
    violationsOf(x_, 1.0);
    const double allowed = tolerance::linearProgram * (1.0 + x_.cwiseAbs().maxCoeff());
    if (withSymbol || first) {
      for (int i = 0; i < rows_; ++i)
        if (consider(i, withSymbol ? rayViolation_[i] : 0.0, violation_[i], allowed, found) && first)
          return found;
    } else {
      excess_ = allowed;
      for (int i = 0; i < rows_; ++i)
        if (violation_[i] > excess_) {
          excess_ = violation_[i];
          found = i;
        }
      if (found < 0) excess_ = 0.0;
    }
    for (int bound = 0; bound < 2 * size; ++bound) {
      const int j = bound % size;
      const double sign = bound < size ? 1.0 : -1.0;
      const Rhs r = rhs(rows_ + bound);
      if (consider(rows_ + bound, sign * ray_[j] - r.symbol, sign * x_[j] - r.number, allowed, found) &&
          first)
        return found;
    }
    return found;
  }

  /// Takes a constraint as the most violated one if it is; violations are ordered by the symbol's multiple.
  bool consider(int constraint, double growth, double excess, double allowed, int& found) {
    if (std::abs(growth) <= tolerance::linearProgram) growth = 0.0;
    const bool violated = growth > 0.0 || (growth == 0.0 && excess > allowed);
    if (!violated || (found >= 0 && (growth < growth_ || (growth == growth_ && excess <= excess_))))
      return false;
    growth_ = growth;
    excess_ = excess;
    found = constraint;
    return true;
  }

  /// The constraint of the basis that gives way, so that all prices stay positive; -1: none can.
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
    if (symbolic_) ray_ -= growth_ * columns_.col(leaving);
    basis_[leaving] = entering;
  }

  LinearProgram::Solution finished(LinearProgram::Solution& solution) {
    bool bounded = true;
    for (int i = 0; i < size; ++i)
      bounded = bounded && !(rhs(basis_[i]).symbol > 0.0 && price_[i] > tolerance::linearProgram);
    solution.status = bounded ? LinearProgram::Status::optimal : LinearProgram::Status::unbounded;
    if (bounded) solution.x = x_ + leastSymbol() * ray_;
    return solution;
  }

  /// The smallest number that the symbol can stand for. (All numbers above it will do too.)
  double leastSymbol() {
    if (!symbolic_ || ray_.isZero(0.0)) return 0.0;
    violationsOf(ray_, 0.0);
    rayViolation_ = violation_;
    violationsOf(x_, 1.0);
    double least = 0.0;
    const auto demand = [&](double growth, double excess) {
      if (growth < -tolerance::linearProgram) least = std::max(least, excess / -growth);
    };
    for (int i = 0; i < rows_; ++i) demand(rayViolation_[i], violation_[i]);
    for (int j = 0; j < size; ++j) {
      if (std::isfinite(p_.upper[j])) demand(ray_[j], x_[j] - p_.upper[j]);
      if (std::isfinite(p_.lower[j])) demand(-ray_[j], p_.lower[j] - x_[j]);
    }
    return least;
  }

  const LinearProgram& p_;
  int rows_;
  bool symbolic_ = false;
  int basis_[size];
  Matrix columns_;  ///< of the inverse: where x goes when a constraint of the basis is relaxed
  Vector x_, ray_;  ///< the basic solution is x_ + symbol * ray_
  Vector price_;    ///< of the constraints of the basis, >= 0
  double growth_ = 0.0, excess_ = 0.0;
  std::vector<double> violation_, rayViolation_;
};

void LinearProgram::clear() {
  for (std::vector<double>& column : column_) column.clear();
  rhs_.clear();
  contradiction_ = false;
}

void LinearProgram::addRow(const Vector& a, double b) {
  const double length = a.norm();
  if (!(length > 0.0)) {
    contradiction_ = contradiction_ || b < -tolerance::linearProgram;
    return;
  }
  for (int j = 0; j < size; ++j) column_[j].push_back(a[j] / length);
  rhs_.push_back(b / length);
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
