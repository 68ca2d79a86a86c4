// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/growth_kernels.h"

#include "packMesh/simd/lanes.h"

namespace packmesh {
namespace {

constexpr int size = LinearProgramView::size;
constexpr int padded = 8;  ///< entries of a vector of `size`, so that it fills registers
constexpr double infinite = 1e300;
constexpr long long none = 1ll << 40;  ///< no row

/// Number of pivots after which the inverse is recomputed.
constexpr int pivotsPerInverse = 30;

/// More than the error that so many pivots accumulate: with a larger tolerance it need not be removed at the
/// end.
constexpr double errorOfPivots = 1e-8;

/// Number of pivots without progress after which Bland's rule is used.
constexpr int patience = 3 * size;

/// Doubles in a register of the current instruction set.
constexpr int doubles = registerLanes / 2;
typedef double DoubleRegister __attribute__((vector_size(doubles * sizeof(double))));
typedef double UnalignedDoubles __attribute__((vector_size(doubles * sizeof(double)), may_alias, aligned(8)));
typedef long long LongRegister __attribute__((vector_size(doubles * sizeof(long long))));

inline DoubleRegister loadDoubles(const double* p) {
  return *reinterpret_cast<const UnalignedDoubles*>(p);
}

struct Vector {
  double v[padded] = {};
  double& operator[](int i) { return v[i]; }
  double operator[](int i) const { return v[i]; }
};

/// One run of the algorithm. Constraints are numbered: rows, then upper bounds, then lower bounds.
class DualSimplex {
 public:
  DualSimplex(const LinearProgramView& program, double tolerance)
      : p_(program), rows_(program.rows), tolerance_(tolerance) {
    for (int j = 0; j < size; ++j) {
      const bool up = p_.objective[j] > 0.0;
      basis_[j] = rows_ + (up ? j : size + j);
      inverse_[j][j] = up ? 1.0 : -1.0;
      x_[j] = up ? p_.upper[j] : p_.lower[j];
      price_[j] = up ? p_.objective[j] : -p_.objective[j];
    }
  }

  void solve(LinearProgramResult& result) {
    int sinceInverse = 0, sinceProgress = 0;
    const int most = 1000 + 20 * rows_;
    while (result.pivots < most) {
      const int entering = findViolated(sinceProgress > patience);
      if (entering < 0 && (sinceInverse == 0 || tolerance_ > errorOfPivots)) {
        result.status = LinearProgramStatus::optimal;
        for (int j = 0; j < size; ++j) result.x[j] = x_[j];
        return;
      }
      Vector alpha;
      int leaving = -1;
      if (entering >= 0) {
        alpha = alongBasis(entering);
        leaving = findLeaving(alpha, sinceProgress > patience);
      }
      if (leaving < 0) {
        if (sinceInverse == 0) {
          result.status = LinearProgramStatus::infeasible;
          return;
        }
        // Accumulated rounding errors must not decide.
        if (!invert()) return;
        sinceInverse = 0;
        continue;
      }
      sinceProgress = price_[leaving] > tolerance_ * alpha[leaving] ? 0 : sinceProgress + 1;
      pivot(entering, leaving, alpha);
      ++result.pivots;
      if (++sinceInverse < pivotsPerInverse) continue;
      if (!invert()) return;
      sinceInverse = 0;
    }
  }

 private:
  double coefficient(int constraint, int j) const {
    if (constraint < rows_) return p_.column[j][constraint];
    const int bound = constraint - rows_;
    if (bound % size != j) return 0.0;
    return bound < size ? 1.0 : -1.0;
  }

  double rhs(int constraint) const {
    if (constraint < rows_) return p_.rhs[constraint];
    const int bound = constraint - rows_, j = bound % size;
    return bound < size ? p_.upper[j] : -p_.lower[j];
  }

  /// Components of a constraint's normal along those of the basis.
  Vector alongBasis(int constraint) const {
    Vector alpha;
    if (constraint >= rows_) {
      const int bound = constraint - rows_;
      for (int i = 0; i < padded; ++i)
        alpha[i] = bound < size ? inverse_[bound][i] : -inverse_[bound - size][i];
      return alpha;
    }
    double a[size];
    for (int j = 0; j < size; ++j) a[j] = p_.column[j][constraint];
    for (int i = 0; i < padded; ++i)
      alpha[i] = ((a[0] * inverse_[0][i] + a[1] * inverse_[1][i]) +
                  (a[2] * inverse_[2][i] + a[3] * inverse_[3][i])) +
                 ((a[4] * inverse_[4][i] + a[5] * inverse_[5][i]) + a[6] * inverse_[6][i]);
    return alpha;
  }

  /// Inverse (by Gauss and Jordan), solution and prices of the basis. @return false: it is singular
  bool invert() {
    double m[size][2 * padded] = {};
    for (int i = 0; i < size; ++i) {
      for (int j = 0; j < size; ++j) m[i][j] = coefficient(basis_[i], j);
      m[i][padded + i] = 1.0;
    }
    for (int c = 0; c < size; ++c) {
      int best = c;
      for (int r = c + 1; r < size; ++r)
        if (magnitudeOf(m[r][c]) > magnitudeOf(m[best][c])) best = r;
      if (!(magnitudeOf(m[best][c]) > 0.0)) return false;
      const double factor = 1.0 / m[best][c];
      for (int k = 0; k < 2 * padded; ++k) {
        const double kept = m[best][k];
        m[best][k] = m[c][k];
        m[c][k] = factor * kept;
      }
      for (int r = 0; r < size; ++r) {
        if (r == c) continue;
        const double f = m[r][c];
        for (int k = 0; k < 2 * padded; ++k) m[r][k] -= f * m[c][k];
      }
    }
    Vector price;
    for (int j = 0; j < size; ++j) {
      double x = 0.0;
      for (int i = 0; i < padded; ++i) {
        inverse_[j][i] = m[j][padded + i];
        price[i] += p_.objective[j] * inverse_[j][i];
      }
      for (int i = 0; i < size; ++i) x += rhs(basis_[i]) * inverse_[j][i];
      x_[j] = x;
    }
    for (int i = 0; i < padded; ++i) price_[i] = price[i] > 0.0 ? price[i] : 0.0;
    return true;
  }

  static double magnitudeOf(double v) { return v < 0.0 ? -v : v; }

  /// Summed in pairs: shorter chains.
  template <class Value, class Load>
  static Value sumOf(const Vector& x, const Load& load) {
    const Value a = x[0] * load(0) + x[1] * load(1), b = x[2] * load(2) + x[3] * load(3),
                c = x[4] * load(4) + x[5] * load(5);
    return (a + b) + (c + x[6] * load(6));
  }
  DoubleRegister violations(int row) const {
    return sumOf<DoubleRegister>(x_, [&](int j) { return loadDoubles(p_.column[j] + row); }) -
           loadDoubles(p_.rhs + row);
  }
  double violation(int row) const {
    return sumOf<double>(x_, [&](int j) { return p_.column[j][row]; }) - p_.rhs[row];
  }

  /// The most violated row, or with `first` the first one, that is violated by more than excess_, which
  /// becomes its violation; -1: none.
  int findViolatedRow(bool first) {
    if (first) {
      for (int i = 0; i < rows_; ++i)
        if (violation(i) > excess_) {
          excess_ = violation(i);
          return i;
        }
      return -1;
    }
    // Two chains, so that one need not wait for the other; each lane remembers the first of its largest.
    DoubleRegister most[2];
    LongRegister at[2];
    for (int k = 0; k < 2; ++k) {
      most[k] = excess_ - DoubleRegister{};
      at[k] = none - LongRegister{};
    }
    for (int row = 0; row < rows_; row += 2 * doubles)
      for (int k = 0; k < 2; ++k) {
        const DoubleRegister v = violations(row + k * doubles);
        const LongRegister more = v > most[k];
        most[k] = more ? v : most[k];
        at[k] = more ? (row + k * doubles) - LongRegister{} : at[k];
      }
    const LongRegister second = (most[1] > most[0]) | ((most[1] == most[0]) & (at[1] < at[0]));
    most[0] = second ? most[1] : most[0];
    at[0] = second ? at[1] : at[0];
    long long found = none;
    for (int lane = 0; lane < doubles; ++lane) {
      const long long row = at[0][lane] + lane;
      if (at[0][lane] == none || most[0][lane] < excess_ || (most[0][lane] == excess_ && row > found))
        continue;
      excess_ = most[0][lane];
      found = row;
    }
    return found == none ? -1 : static_cast<int>(found);
  }

  /// The most violated constraint, or with `first` the first one; -1: none. The violation is stored in
  /// `excess_`.
  int findViolated(bool first) {
    double largest = 0.0;
    for (int j = 0; j < size; ++j) largest = magnitudeOf(x_[j]) > largest ? magnitudeOf(x_[j]) : largest;
    excess_ = tolerance_ * (1.0 + largest);
    int found = findViolatedRow(first);
    if (first && found >= 0) return found;
    int outside = 0;
    for (int j = 0; j < size; ++j)
      outside |= int{x_[j] - p_.upper[j] > excess_} | int{p_.lower[j] - x_[j] > excess_};
    if (!outside) return found;
    for (int bound = 0; bound < 2 * size; ++bound) {
      const double x = x_[bound % size];
      const double violation = bound < size ? x - p_.upper[bound] : p_.lower[bound - size] - x;
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
    Vector ratio;
    double least = infinite;
    for (int i = 0; i < size; ++i) ratio[i] = alpha[i] > tolerance_ ? price_[i] / alpha[i] : infinite;
    for (int i = 0; i < size; ++i) least = ratio[i] < least ? ratio[i] : least;
    if (!(least < infinite)) return -1;
    const double tie = least + 1e-3 * tolerance_ * (1.0 + least);
    int leaving = -1;
    for (int i = 0; i < size; ++i) {
      if (ratio[i] > tie) continue;
      if (leaving < 0 || (bland ? basis_[i] < basis_[leaving] : alpha[i] > alpha[leaving])) leaving = i;
    }
    return leaving;
  }

  void pivot(int entering, int leaving, const Vector& alpha) {
    const double inverse = 1.0 / alpha[leaving], price = price_[leaving] * inverse;
    for (int j = 0; j < size; ++j) {
      const double moved = inverse * inverse_[j][leaving];
      for (int i = 0; i < padded; ++i) inverse_[j][i] -= alpha[i] * moved;
      inverse_[j][leaving] = moved;
      x_[j] -= excess_ * moved;
    }
    for (int i = 0; i < padded; ++i) {
      const double left = price_[i] - alpha[i] * price;
      price_[i] = left > 0.0 ? left : 0.0;
    }
    price_[leaving] = price;
    basis_[leaving] = entering;
  }

  const LinearProgramView& p_;
  int rows_;
  double tolerance_;
  int basis_[size];
  /// Columns of the inverse: directions in which x moves when a constraint of the basis is relaxed.
  double inverse_[size][padded] = {};
  Vector x_;             ///< the basic solution
  Vector price_;         ///< of the constraints of the basis, >= 0
  double excess_ = 0.0;  ///< of the constraint that findViolated() found
};

void solve(const LinearProgramView& program, double tolerance, LinearProgramResult& result) {
  DualSimplex(program, tolerance).solve(result);
}

}  // namespace

template <InstructionSet set>
LinearProgramKernel linearProgramKernel() {
  return solve;
}
template LinearProgramKernel linearProgramKernel<InstructionSet::PACKMESH_INSTRUCTION_SET>();

}  // namespace packmesh
