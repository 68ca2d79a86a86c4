// SPDX-License-Identifier: AGPL-3.0-or-later
// Packings of all versions have the same bytes, and those of the first were computed with Eigen, so that its
// bits are asked for.
#include "packMesh/core/vector.h"
#include "tests/support/catch.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <limits>
#include <random>
#include <vector>

using namespace packmesh;

namespace {

using EigenVec = Eigen::Vector3d;
using EigenMat = Eigen::Matrix3d;
using EigenTurn = Eigen::Quaterniond;

std::mt19937 engine(7);

double number() {
  return std::uniform_real_distribution<double>(-2.0, 2.0)(engine);
}

template <int N>
Vec<double, N> vector() {
  Vec<double, N> v;
  for (double& c : v) c = number();
  return v;
}

template <int N>
Eigen::Matrix<double, N, 1> in(const Vec<double, N>& v) {
  return Eigen::Map<const Eigen::Matrix<double, N, 1>>(v.data());
}
EigenMat in(const Mat3& m) {
  return Eigen::Map<const EigenMat>(m.data());
}
EigenTurn in(const Quaternion& q) {
  return EigenTurn(q.w(), q.x(), q.y(), q.z());
}

Mat3 matrix() {
  return {vector<3>(), vector<3>(), vector<3>()};
}
Quaternion turn() {
  return Quaternion(vector<4>()).normalized();
}

/// Whether all numbers are the same.
template <class A, class B>
bool same(const A& a, const B& b) {
  return std::equal(a.data(), a.data() + b.size(), b.data());
}
bool same(const Quaternion& a, const EigenTurn& b) {
  return same(a.coeffs(), b.coeffs());
}

template <int N>
void compareSums() {
  const Vec<double, N> a = vector<N>(), b = vector<N>();
  REQUIRE(a.sum() == in<N>(a).sum());
  REQUIRE(a.dot(b) == in<N>(a).dot(in<N>(b)));
  REQUIRE(a.norm() == in<N>(a).norm());
  REQUIRE((a - b).squaredNorm() == (in<N>(a) - in<N>(b)).squaredNorm());
  REQUIRE(same(a.normalized(), in<N>(a).normalized()));
}

}  // namespace

TEST_CASE("Vectors have the bits of Eigen's", "[vector]") {
  for (int i = 0; i < 1000; ++i) {
    compareSums<2>();
    compareSums<3>();
    compareSums<4>();
    const Vec<double, 7> seven = vector<7>();
    REQUIRE(seven.squaredNorm() == in<7>(seven).squaredNorm());
    const Vec3f f = vector<3>().cast<float>(), g = vector<3>().cast<float>();
    const Eigen::Vector3f ef(f.data()), eg(g.data());
    REQUIRE(f.dot(g) == ef.dot(eg));
    REQUIRE(f.norm() == ef.norm());

    const Vec3 a = vector<3>(), b = vector<3>();
    const EigenVec ea = in<3>(a), eb = in<3>(b);
    REQUIRE(a.prod() == ea.prod());
    REQUIRE(same(a.cross(b), ea.cross(eb)));
    REQUIRE(same(0.3 * a + b / 0.7 - a.cwiseProduct(b), EigenVec(0.3 * ea + eb / 0.7 - ea.cwiseProduct(eb))));
    REQUIRE(same(a.cwiseMin(b).cwiseMax(0.1), EigenVec(ea.cwiseMin(eb).cwiseMax(0.1))));
    REQUIRE(same(a.unitOrthogonal(), ea.unitOrthogonal()));
    REQUIRE(same((1e200 * a).stableNormalized(), (1e200 * ea).stableNormalized()));
    REQUIRE(a.cwiseAbs().sum() == ea.lpNorm<1>());
    REQUIRE(a.head<2>().norm() == ea.head<2>().norm());
    REQUIRE(same(Vec3(a.array().floor() + 0.5), EigenVec(ea.array().floor() + 0.5)));
    REQUIRE((a.array() <= b.array()).count() == (ea.array() <= eb.array()).count());
    int ours, theirs;
    REQUIRE(a.maxCoeff(&ours) == ea.maxCoeff(&theirs));
    REQUIRE(ours == theirs);
    REQUIRE(a.minCoeff(&ours) == ea.minCoeff(&theirs));
    REQUIRE(ours == theirs);
  }
  REQUIRE(same(Vec3(0, 0, -2).unitOrthogonal(), EigenVec(0, 0, -2).unitOrthogonal()));
}

TEST_CASE("Matrices have the bits of Eigen's", "[vector]") {
  for (int i = 0; i < 1000; ++i) {
    const Mat3 a = matrix(), b = matrix();
    const EigenMat ea = in(a), eb = in(b);
    const Vec3 v = vector<3>();
    const EigenVec ev = in<3>(v);
    REQUIRE(same(a * v, EigenVec(ea * ev)));
    REQUIRE(same(v + a * v, EigenVec(ev + ea * ev)));
    REQUIRE(same(a.transpose() * v, EigenVec(ea.transpose() * ev)));
    REQUIRE(same(Mat3(a.transpose()) * v, EigenVec(EigenMat(ea.transpose()) * ev)));
    REQUIRE(Mat3(ea * eb) == a * b);
    REQUIRE(Mat3(ea.transpose() * eb) == a.transpose() * b);
    REQUIRE(Mat3(ea * eb.transpose()) == a * b.transpose());
    REQUIRE(Mat3(ea.inverse()) == a.inverse());
    REQUIRE(Mat3(0.3 * ea - eb / 0.7) == 0.3 * a - b / 0.7);
    REQUIRE(a.determinant() == ea.determinant());
    REQUIRE(a.trace() == ea.trace());
    REQUIRE(Mat3(ev * (ea * ev).transpose()) == Mat3::outerProduct(v, a * v));
  }
}

TEST_CASE("Rotations have the bits of Eigen's", "[vector]") {
  for (int i = 0; i < 1000; ++i) {
    const Quaternion p = turn(), q = turn();
    const EigenTurn ep = in(p), eq = in(q);
    const Vec3 v = vector<3>(), w = vector<3>();
    REQUIRE(same(p * q, ep * eq));
    REQUIRE(same(p * v, EigenVec(ep * in<3>(v))));
    REQUIRE(same(p.normalized(), ep.normalized()));
    REQUIRE(Mat3(ep.toRotationMatrix()) == p.toRotationMatrix());
    REQUIRE(same(Quaternion(p.toRotationMatrix()), EigenTurn(ep.toRotationMatrix())));
    REQUIRE(p.angularDistance(q) == ep.angularDistance(eq));
    REQUIRE(p.dot(q) == ep.dot(eq));
    REQUIRE(same(p.inverse(), ep.inverse()));
    REQUIRE(same(Quaternion::FromTwoVectors(v, w), EigenTurn::FromTwoVectors(in<3>(v), in<3>(w))));
    const Vec3 axis = v.normalized();
    REQUIRE(same(Quaternion::around(axis, w.x()), EigenTurn(Eigen::AngleAxisd(w.x(), in<3>(axis)))));
  }
}

TEST_CASE("Opposite vectors are turned into one another", "[vector]") {
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const Vec3 v = side * Vec3::Unit(axis);
      REQUIRE(same(Quaternion::FromTwoVectors(v, -v), EigenTurn::FromTwoVectors(in<3>(v), -in<3>(v))));
    }
  for (int i = 0; i < 100; ++i) {
    const Vec3 v = vector<3>(), to = -0.5 * v + 1e-8 * vector<3>();
    const Quaternion half = Quaternion::FromTwoVectors(v, to);
    REQUIRE(std::abs(half.norm() - 1.0) < 1e-12);
    REQUIRE((half * v.normalized() - to.normalized()).norm() < 1e-5);
  }
}

TEST_CASE("Eigenvectors are those of the eigenvalues in order", "[vector]") {
  const Mat3 root = matrix(), m = root * root.transpose();
  const PrincipalAxes axes = principalAxes(m);
  for (int k = 0; k < 3; ++k) {
    REQUIRE((k == 0 || axes.values[k - 1] <= axes.values[k]));
    REQUIRE((m * axes.vectors.col(k)).isApprox(axes.values[k] * axes.vectors.col(k), 1e-9));
  }
}

TEST_CASE("Points of other libraries are vectors", "[vector]") {
  struct Point {
    double of[3];
    double x() const { return of[0]; }
    double y() const { return of[1]; }
    double z() const { return of[2]; }
    double operator[](int k) const { return of[k]; }
  };
  const Vec3 v = Point{{1.0, 2.0, 3.0}};
  REQUIRE(v == Vec3(1, 2, 3));
  REQUIRE(Vec3(EigenVec(1, 2, 3)) == v);
  REQUIRE(!std::is_convertible_v<Vec2, Vec3>);
  REQUIRE(!std::is_convertible_v<Quaternion, Vec3>);
  REQUIRE(!std::is_convertible_v<std::vector<double>, Vec3>);
}

TEST_CASE("Comparisons with what is not a number are false", "[vector]") {
  const Vec3 v(1, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
  REQUIRE(!v.allFinite());
  REQUIRE(v.array().isFinite().count() == 1);
  REQUIRE((v.array() <= v.array()).count() == 2);
  REQUIRE(!v.isZero(2.0));
  REQUIRE(v != v);
#ifdef PACKMESH_VECTORS_BEGIN_AS_NAN
  const Vec3 unset;
  REQUIRE(std::isnan(unset.x()));
#endif
}

static_assert(Vec3(3, 4, 0).cross(Vec3::UnitZ()).squaredNorm() == 25.0);
static_assert((Mat3::Identity() * Vec3(1, 2, 3)).dot(Vec3::Ones()) == 6.0);
static_assert((Quaternion(0.0, 1.0, 0.0, 0.0) * Vec3(1, 2, 3)) == Vec3(1, -2, -3));
static_assert(sizeof(Vec3) == 24 && alignof(Quaternion) == 16 && std::is_trivially_copyable_v<Quaternion>);
