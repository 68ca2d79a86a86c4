// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Small vectors, 3 x 3 matrices and rotations, and numbers and points as text for messages. Lengths
/// are in µm.
///
/// Plain values: functions return what they compute, not expressions of it, so that compilers keep all in
/// registers and read this header in no time. Members have the names that linear algebra libraries use. The
/// order in which terms are added is a part of each function, because packings depend on every bit.
#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

namespace packmesh {

template <class T, int N>
class Vec;
template <class T, int N>
class Array;

using Vec2 = Vec<double, 2>;
using Vec3 = Vec<double, 3>;
using Vec3f = Vec<float, 3>;

template <class T>
inline constexpr bool isVec = false;
template <class T, int N>
inline constexpr bool isVec<Vec<T, N>> = true;

/// Relative differences far above those of rounding, and below those that matter.
inline constexpr double aboutEqual = 1e-12;

/// N coordinates. Those of `Vec v;` are not initialised, or NaN in builds with PACKMESH_CHECKS.
template <class T, int N>
class Vec {
 public:
  constexpr Vec(T x, T y) : c_{x, y} { static_assert(N == 2); }
  constexpr Vec(T x, T y, T z) : c_{x, y, z} { static_assert(N == 3); }
  constexpr Vec(T x, T y, T z, T w) : c_{x, y, z, w} { static_assert(N == 4); }
  explicit constexpr Vec(const T* first) : c_{} {
    for (int k = 0; k < N; ++k) c_[k] = first[k];
  }
  /// From a point of another library: it has x(), y(), z() and [].
  template <class Point, class = decltype(std::declval<const Point&>().z(), std::declval<const Point&>()[0]),
            class = std::enable_if_t<!isVec<Point>>>
  constexpr Vec(const Point& p) : Vec(T(p.x()), T(p.y()), T(p.z())) {}

  static constexpr Vec Constant(T value) {
    const T one[N] = {};
    Vec v(one);
    for (T& c : v) c = value;
    return v;
  }
  static constexpr Vec Zero() { return Constant(T(0)); }
  static constexpr Vec Ones() { return Constant(T(1)); }
  static constexpr Vec Unit(int axis) {
    Vec v = Zero();
    v[axis] = T(1);
    return v;
  }
  static constexpr Vec UnitX() { return Unit(0); }
  static constexpr Vec UnitY() { return Unit(1); }
  static constexpr Vec UnitZ() { return Unit(2); }

  constexpr T& operator[](int k) { return c_[k]; }
  constexpr const T& operator[](int k) const { return c_[k]; }
  constexpr T& x() { return c_[0]; }
  constexpr T& y() { return c_[1]; }
  constexpr T& z() { return c_[2]; }
  constexpr const T& x() const { return c_[0]; }
  constexpr const T& y() const { return c_[1]; }
  constexpr const T& z() const { return c_[2]; }
  constexpr T* data() { return c_; }
  constexpr const T* data() const { return c_; }
  constexpr T* begin() { return c_; }
  constexpr T* end() { return c_ + N; }
  constexpr const T* begin() const { return c_; }
  constexpr const T* end() const { return c_ + N; }
  static constexpr int size() { return N; }

  constexpr Vec& operator+=(const Vec& b) {
    for (int k = 0; k < N; ++k) c_[k] += b.c_[k];
    return *this;
  }
  constexpr Vec& operator-=(const Vec& b) {
    for (int k = 0; k < N; ++k) c_[k] -= b.c_[k];
    return *this;
  }
  constexpr Vec& operator*=(T s) {
    for (T& c : c_) c *= s;
    return *this;
  }
  constexpr Vec& operator/=(T s) {
    for (T& c : c_) c /= s;
    return *this;
  }
  friend constexpr Vec operator+(Vec a, const Vec& b) { return a += b; }
  friend constexpr Vec operator-(Vec a, const Vec& b) { return a -= b; }
  friend constexpr Vec operator*(Vec a, T s) { return a *= s; }
  friend constexpr Vec operator*(T s, Vec a) { return a *= s; }
  friend constexpr Vec operator/(Vec a, T s) { return a /= s; }
  friend constexpr Vec operator-(Vec a) {
    for (T& c : a.c_) c = -c;
    return a;
  }
  friend constexpr bool operator==(const Vec& a, const Vec& b) {
    bool same = true;
    for (int k = 0; k < N; ++k) same = same && a.c_[k] == b.c_[k];
    return same;
  }
  friend constexpr bool operator!=(const Vec& a, const Vec& b) { return !(a == b); }

  constexpr Vec cwiseProduct(const Vec& b) const {
    Vec a = *this;
    for (int k = 0; k < N; ++k) a.c_[k] *= b.c_[k];
    return a;
  }
  constexpr Vec cwiseQuotient(const Vec& b) const {
    Vec a = *this;
    for (int k = 0; k < N; ++k) a.c_[k] /= b.c_[k];
    return a;
  }
  constexpr Vec cwiseInverse() const { return Ones().cwiseQuotient(*this); }
  constexpr Vec cwiseMin(const Vec& b) const {
    Vec a = *this;
    for (int k = 0; k < N; ++k) a.c_[k] = b.c_[k] < a.c_[k] ? b.c_[k] : a.c_[k];
    return a;
  }
  constexpr Vec cwiseMax(const Vec& b) const {
    Vec a = *this;
    for (int k = 0; k < N; ++k) a.c_[k] = a.c_[k] < b.c_[k] ? b.c_[k] : a.c_[k];
    return a;
  }
  constexpr Vec cwiseMin(T b) const { return cwiseMin(Constant(b)); }
  constexpr Vec cwiseMax(T b) const { return cwiseMax(Constant(b)); }
  Vec cwiseAbs() const {
    Vec a = *this;
    for (T& c : a.c_) c = std::abs(c);
    return a;
  }
  template <class To>
  constexpr Vec<To, N> cast() const {
    auto to = Vec<To, N>::Zero();
    for (int k = 0; k < N; ++k) to[k] = static_cast<To>(c_[k]);
    return to;
  }
  template <int M>
  constexpr Vec<T, M> head() const {
    return Vec<T, M>(c_);
  }
  template <int M>
  constexpr Vec<T, M> tail() const {
    return Vec<T, M>(c_ + N - M);
  }

  /// x + y + z of doubles and x + (y + z) of floats. Of more, those at even and at odd places are added
  /// apart, each from the last pair on, and a single last one at the end.
  constexpr T sum() const {
    if constexpr (N == 3 && std::is_same_v<T, float>) {
      return c_[0] + (c_[1] + c_[2]);
    } else {
      constexpr int paired = N / 2 * 2;
      T even = c_[paired - 2], odd = c_[paired - 1];
      for (int k = paired - 4; k >= 0; k -= 2) {
        even = c_[k] + even;
        odd = c_[k + 1] + odd;
      }
      return paired < N ? even + odd + c_[N - 1] : even + odd;
    }
  }
  constexpr T prod() const {
    T product = c_[0];
    for (int k = 1; k < N; ++k) product *= c_[k];
    return product;
  }
  constexpr T dot(const Vec& b) const { return cwiseProduct(b).sum(); }
  constexpr Vec cross(const Vec& b) const {
    return {y() * b.z() - z() * b.y(), z() * b.x() - x() * b.z(), x() * b.y() - y() * b.x()};
  }
  constexpr T squaredNorm() const { return dot(*this); }
  T norm() const { return std::sqrt(squaredNorm()); }
  /// In the same direction with norm 1; a vector of zeros stays one.
  Vec normalized() const {
    const T square = squaredNorm();
    return square > T(0) ? *this / std::sqrt(square) : *this;
  }
  /// The same where squares overflow or vanish.
  T stableNorm() const {
    const T largest = cwiseAbs().maxCoeff();
    return largest > T(0) && std::isfinite(largest) ? largest * (*this / largest).norm() : largest;
  }
  Vec stableNormalized() const {
    const T largest = cwiseAbs().maxCoeff(), square = (*this / largest).squaredNorm();
    return square > T(0) ? *this / (std::sqrt(square) * largest) : *this;
  }
  /// Perpendicular to this one, of norm 1.
  Vec unitOrthogonal() const {
    static_assert(N == 3);
    constexpr T small = T(aboutEqual);
    if (std::abs(x()) <= std::abs(z()) * small && std::abs(y()) <= std::abs(z()) * small) {
      const T inverse = T(1) / tail<2>().norm();
      return {T(0), -z() * inverse, y() * inverse};
    }
    const T inverse = T(1) / head<2>().norm();
    return {-y() * inverse, x() * inverse, T(0)};
  }

  constexpr T minCoeff() const {
    return c_[indexOfFirst([](T a, T b) { return a < b; })];
  }
  constexpr T maxCoeff() const {
    return c_[indexOfFirst([](T a, T b) { return a > b; })];
  }
  /// @param index receives where it is, the first of several
  template <class Index>
  constexpr T minCoeff(Index* index) const {
    return c_[*index = indexOfFirst([](T a, T b) { return a < b; })];
  }
  template <class Index>
  constexpr T maxCoeff(Index* index) const {
    return c_[*index = indexOfFirst([](T a, T b) { return a > b; })];
  }
  bool allFinite() const { return array().isFinite().all(); }
  bool isZero(T precision = T(aboutEqual)) const { return (cwiseAbs().array() <= precision).all(); }
  bool isApprox(const Vec& b, T precision = T(aboutEqual)) const {
    const T a2 = squaredNorm(), b2 = b.squaredNorm();
    return (*this - b).squaredNorm() <= precision * precision * (b2 < a2 ? b2 : a2);
  }

  constexpr void setConstant(T value) { *this = Constant(value); }
  constexpr void setZero() { setConstant(T(0)); }
  void normalize() { *this = normalized(); }
  constexpr Array<T, N> array() const { return {*this}; }

#ifdef PACKMESH_VECTORS_BEGIN_AS_NAN
  constexpr Vec() : Vec(Constant(std::numeric_limits<T>::quiet_NaN())) {}
#else
  Vec() = default;
#endif

 private:
  template <class Before>
  constexpr int indexOfFirst(const Before& before) const {
    int first = 0;
    for (int k = 1; k < N; ++k)
      if (before(c_[k], c_[first])) first = k;
    return first;
  }

  T c_[N];
};

/// For which coordinates a comparison holds.
template <int N>
struct Mask {
  bool of[N];

  constexpr int count() const {
    int n = 0;
    for (const bool holds : of) n += holds;
    return n;
  }
  constexpr bool all() const { return count() == N; }
  constexpr bool any() const { return count() > 0; }
};

/// Coordinates as numbers of their own, beside which one number stands for N equal ones.
template <class T, int N>
class Array {
 public:
  constexpr Array(const Vec<T, N>& v) : v_(v) {}
  constexpr Array(T value) : v_(Vec<T, N>::Constant(value)) {}
  constexpr operator Vec<T, N>() const { return v_; }

  friend constexpr Array operator+(const Array& a, const Array& b) { return a.v_ + b.v_; }
  friend constexpr Array operator-(const Array& a, const Array& b) { return a.v_ - b.v_; }
  friend constexpr Array operator*(const Array& a, const Array& b) { return a.v_.cwiseProduct(b.v_); }
  friend constexpr Array operator/(const Array& a, const Array& b) { return a.v_.cwiseQuotient(b.v_); }
  friend constexpr Mask<N> operator<(const Array& a, const Array& b) {
    return a.compare(b, [](T x, T y) { return x < y; });
  }
  friend constexpr Mask<N> operator<=(const Array& a, const Array& b) {
    return a.compare(b, [](T x, T y) { return x <= y; });
  }
  friend constexpr Mask<N> operator>(const Array& a, const Array& b) { return b < a; }
  friend constexpr Mask<N> operator>=(const Array& a, const Array& b) { return b <= a; }
  Mask<N> isFinite() const {
    return compare(*this, [](T x, T) { return std::isfinite(x); });
  }
  Array floor() const {
    return map([](T x) { return std::floor(x); });
  }
  Array ceil() const {
    return map([](T x) { return std::ceil(x); });
  }
  Array round() const {
    return map([](T x) { return std::round(x); });
  }
  constexpr Array max(const Array& b) const { return v_.cwiseMax(b.v_); }
  constexpr T prod() const { return v_.prod(); }

 private:
  template <class Holds>
  constexpr Mask<N> compare(const Array& b, const Holds& holds) const {
    Mask<N> mask{};
    for (int k = 0; k < N; ++k) mask.of[k] = holds(v_[k], b.v_[k]);
    return mask;
  }
  template <class Function>
  Array map(const Function& function) const {
    Array a = *this;
    for (T& c : a.v_) c = function(c);
    return a;
  }

  Vec<T, N> v_;
};

/// A 3 x 3 matrix of doubles, stored by columns.
class Mat3 {
 public:
  Mat3() = default;
  constexpr Mat3(const Vec3& column0, const Vec3& column1, const Vec3& column2)
      : column_{column0, column1, column2} {}
  /// From a matrix of another library, which has (row, column).
  template <class Matrix, class = decltype(std::declval<const Matrix&>()(0, 0))>
  explicit constexpr Mat3(const Matrix& m) : Mat3(Zero()) {
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) column_[c][r] = m(r, c);
  }

  static constexpr Mat3 Constant(double value) {
    return {Vec3::Constant(value), Vec3::Constant(value), Vec3::Constant(value)};
  }
  static constexpr Mat3 Zero() { return Constant(0.0); }
  static constexpr Mat3 Identity() { return diagonal(Vec3::Ones()); }
  static constexpr Mat3 diagonal(const Vec3& d) {
    return {{d.x(), 0.0, 0.0}, {0.0, d.y(), 0.0}, {0.0, 0.0, d.z()}};
  }
  /// The matrix of products a_i b_j.
  static constexpr Mat3 outerProduct(const Vec3& a, const Vec3& b) {
    return {a * b.x(), a * b.y(), a * b.z()};
  }

  constexpr double& operator()(int row, int column) { return column_[column][row]; }
  constexpr double operator()(int row, int column) const { return column_[column][row]; }
  constexpr Vec3& col(int column) { return column_[column]; }
  constexpr const Vec3& col(int column) const { return column_[column]; }
  constexpr Vec3 row(int row) const { return {column_[0][row], column_[1][row], column_[2][row]}; }
  /// The nine numbers, by columns.
  constexpr double* data() { return column_[0].data(); }
  constexpr const double* data() const { return column_[0].data(); }
  static constexpr int size() { return 9; }

  constexpr Mat3& operator+=(const Mat3& b) {
    for (int c = 0; c < 3; ++c) column_[c] += b.column_[c];
    return *this;
  }
  constexpr Mat3& operator-=(const Mat3& b) {
    for (int c = 0; c < 3; ++c) column_[c] -= b.column_[c];
    return *this;
  }
  constexpr Mat3& operator*=(double s) {
    for (Vec3& column : column_) column *= s;
    return *this;
  }
  constexpr Mat3& operator/=(double s) {
    for (Vec3& column : column_) column /= s;
    return *this;
  }
  friend constexpr Mat3 operator+(Mat3 a, const Mat3& b) { return a += b; }
  friend constexpr Mat3 operator-(Mat3 a, const Mat3& b) { return a -= b; }
  friend constexpr Mat3 operator*(Mat3 a, double s) { return a *= s; }
  friend constexpr Mat3 operator*(double s, Mat3 a) { return a *= s; }
  friend constexpr Mat3 operator/(Mat3 a, double s) { return a /= s; }
  friend constexpr Mat3 operator-(const Mat3& a) { return {-a.column_[0], -a.column_[1], -a.column_[2]}; }
  friend constexpr bool operator==(const Mat3& a, const Mat3& b) {
    return a.column_[0] == b.column_[0] && a.column_[1] == b.column_[1] && a.column_[2] == b.column_[2];
  }
  friend constexpr bool operator!=(const Mat3& a, const Mat3& b) { return !(a == b); }

  /// x + y + z in the first two rows, x + (y + z) in the third. Where g++ 12 does not inline it, calls are 3
  /// % of the instructions of a dense packing.
  [[gnu::always_inline]] friend constexpr Vec3 operator*(const Mat3& m, const Vec3& v) {
    const Vec3 x = m.column_[0] * v.x(), y = m.column_[1] * v.y(), z = m.column_[2] * v.z();
    return {x[0] + y[0] + z[0], x[1] + y[1] + z[1], x[2] + (y[2] + z[2])};
  }
  friend constexpr Mat3 operator*(const Mat3& a, const Mat3& b) {
    return {a * b.column_[0], a * b.column_[1], a * b.column_[2]};
  }

  /// A matrix by rows, which are the columns of another; its products are dot products with them.
  class Transposed {
   public:
    explicit constexpr Transposed(const Mat3& m) : row_{m.col(0), m.col(1), m.col(2)} {}
    constexpr operator Mat3() const {
      return {{row_[0].x(), row_[1].x(), row_[2].x()},
              {row_[0].y(), row_[1].y(), row_[2].y()},
              {row_[0].z(), row_[1].z(), row_[2].z()}};
    }
    friend constexpr Vec3 operator*(const Transposed& m, const Vec3& v) {
      return {m.row_[0].dot(v), m.row_[1].dot(v), m.row_[2].dot(v)};
    }
    friend constexpr Mat3 operator*(const Transposed& a, const Mat3& b) {
      return {a * b.col(0), a * b.col(1), a * b.col(2)};
    }

   private:
    Vec3 row_[3];
  };
  constexpr Transposed transpose() const { return Transposed(*this); }

  constexpr double trace() const { return column_[0].x() + (column_[1].y() + column_[2].z()); }
  constexpr double determinant() const {
    const auto [a, b, c] = column_;
    return a.x() * (b.y() * c.z() - c.y() * b.z()) - b.x() * (a.y() * c.z() - c.y() * a.z()) +
           c.x() * (a.y() * b.z() - b.y() * a.z());
  }
  /// Not finite if the determinant is 0.
  constexpr Mat3 inverse() const {
    const Vec3 first = column_[1].cross(column_[2]), second = column_[2].cross(column_[0]),
               third = column_[0].cross(column_[1]);
    return Mat3(first, second, third).transpose() * (1.0 / first.dot(column_[0]));
  }
  Mat3 cwiseAbs() const { return {column_[0].cwiseAbs(), column_[1].cwiseAbs(), column_[2].cwiseAbs()}; }
  bool allFinite() const {
    return column_[0].allFinite() && column_[1].allFinite() && column_[2].allFinite();
  }
  double squaredNorm() const {
    return column_[0].squaredNorm() + column_[1].squaredNorm() + column_[2].squaredNorm();
  }
  double norm() const { return std::sqrt(squaredNorm()); }
  bool isApprox(const Mat3& b, double precision = aboutEqual) const {
    const double a2 = squaredNorm(), b2 = b.squaredNorm();
    return (*this - b).squaredNorm() <= precision * precision * (b2 < a2 ? b2 : a2);
  }

 private:
  Vec3 column_[3];
};

/// A rotation, if its norm is 1: (x, y, z) is the axis times the sine of half the angle, w the cosine.
/// Aligned so that two of its numbers fill a register.
class alignas(16) Quaternion {
 public:
  using Coefficients = Vec<double, 4>;  ///< x, y, z, w

  Quaternion() = default;
  constexpr Quaternion(double w, double x, double y, double z) : c_(x, y, z, w) {}
  explicit constexpr Quaternion(const Coefficients& c) : c_(c) {}
  /// Of a rotation matrix (K. Shoemake, SIGGRAPH course notes, 1987).
  explicit Quaternion(const Mat3& rotation);

  static constexpr Quaternion Identity() { return {1.0, 0.0, 0.0, 0.0}; }
  /// By this angle [rad] around an axis of length 1.
  static Quaternion around(const Vec3& axis, double angle);
  /// Turns the direction of one vector into that of another, by the shortest way.
  static Quaternion FromTwoVectors(const Vec3& from, const Vec3& to);

  constexpr double& x() { return c_[0]; }
  constexpr double& y() { return c_[1]; }
  constexpr double& z() { return c_[2]; }
  constexpr double& w() { return c_[3]; }
  constexpr double x() const { return c_[0]; }
  constexpr double y() const { return c_[1]; }
  constexpr double z() const { return c_[2]; }
  constexpr double w() const { return c_[3]; }
  constexpr Vec3 vec() const { return c_.head<3>(); }
  constexpr Coefficients& coeffs() { return c_; }
  constexpr const Coefficients& coeffs() const { return c_; }

  double norm() const { return c_.norm(); }
  constexpr double dot(const Quaternion& b) const { return c_.dot(b.c_); }
  Quaternion normalized() const { return Quaternion(c_.normalized()); }
  void normalize() { c_.normalize(); }
  constexpr Quaternion conjugate() const { return {w(), -x(), -y(), -z()}; }
  constexpr Quaternion inverse() const { return Quaternion(conjugate().c_ / c_.squaredNorm()); }
  /// Of the rotation between both [rad].
  double angularDistance(const Quaternion& b) const {
    const Quaternion d = *this * b.conjugate();
    return 2.0 * std::atan2(d.vec().norm(), std::abs(d.w()));
  }

  /// First b, then a.
  friend constexpr Quaternion operator*(const Quaternion& a, const Quaternion& b) {
    return {(a.w() * b.w() - a.y() * b.y()) - (a.z() * b.z() + a.x() * b.x()),
            (a.w() * b.x() + a.y() * b.z()) - (a.z() * b.y() - a.x() * b.w()),
            (a.w() * b.y() + a.y() * b.w()) + (a.z() * b.x() - a.x() * b.z()),
            (a.w() * b.z() - a.y() * b.x()) + (a.z() * b.w() + a.x() * b.y())};
  }
  friend constexpr Vec3 operator*(const Quaternion& q, const Vec3& v) {
    const Vec3 half = q.vec().cross(v), whole = half + half;
    return v + q.w() * whole + q.vec().cross(whole);
  }
  constexpr Mat3 toRotationMatrix() const {
    const double tx = 2.0 * x(), ty = 2.0 * y(), tz = 2.0 * z();
    const double wx = tx * w(), wy = ty * w(), wz = tz * w(), xx = tx * x(), xy = ty * x(), xz = tz * x(),
                 yy = ty * y(), yz = tz * y(), zz = tz * z();
    return {{1.0 - (yy + zz), xy + wz, xz - wy},
            {xy - wz, 1.0 - (xx + zz), yz + wx},
            {xz + wy, yz - wx, 1.0 - (xx + yy)}};
  }

 private:
  Coefficients c_;
};

/// Of a symmetric matrix: the values, the least first, and the axes of length 1 as columns.
struct PrincipalAxes {
  Vec3 values;
  Mat3 vectors;
};
PrincipalAxes principalAxes(const Mat3& symmetric);

/// Names of the axes 0, 1, 2.
inline constexpr const char* axisName[3] = {"x", "y", "z"};

/// `value` with at most `digits` significant digits: "12.5".
std::string toText(double value, int digits = 6);

/// "(1, 2.5, 3)".
std::string toText(const Vec3& p);

}  // namespace packmesh
