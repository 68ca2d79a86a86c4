// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/vector.h"
#include "tests/packMesh/simd/kernel_inputs.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

std::mt19937_64 engine(7);

/// From -2 to 2, with all bits: the same with every standard library.
double number() {
  return double(engine() >> 11) * 0x1p-51 - 2.0;
}

template <int N>
Vec<double, N> vector() {
  Vec<double, N> v;
  for (double& c : v) c = number();
  return v;
}
Mat3 matrix() {
  return {vector<3>(), vector<3>(), vector<3>()};
}

struct Input {
  Vec2 a2 = vector<2>(), b2 = vector<2>();
  Vec3 a = vector<3>(), b = vector<3>();
  Vec<double, 4> a4 = vector<4>(), b4 = vector<4>();
  Vec<double, 7> a7 = vector<7>();
  Mat3 m = matrix(), n = matrix();
  Quaternion p = Quaternion(vector<4>()).normalized(), q = Quaternion(vector<4>()).normalized();
};

void add(Hash& hash, double value) {
  hash.add(value);
}
void add(Hash& hash, const Mat3& m) {
  for (int k = 0; k < 9; ++k) hash.add(m.data()[k]);
}
void add(Hash& hash, const Quaternion& q) {
  for (const double c : q.coeffs()) hash.add(c);
}
template <class Number, int N>
void add(Hash& hash, const Vec<Number, N>& v) {
  for (const Number c : v) hash.add(c);
}
template <class... Values, class = std::enable_if_t<(sizeof...(Values) > 1)>>
void add(Hash& hash, const Values&... values) {
  (add(hash, values), ...);
}

}  // namespace

// Packings of all versions have the same bytes, and those of the first were computed with Eigen 3.4: these
// are the bits of its functions. Sums have one order, and nothing is contracted.
TEST_CASE("Vectors, matrices and rotations have the bits that Eigen's had", "[vector]") {
  std::map<std::string, Hash> found;
  for (int i = 0; i < 1000; ++i) {
    const Input in;
    add(found["sums"], in.a2.sum(), in.a.sum(), in.a4.sum());
    add(found["dot"], in.a2.dot(in.b2), in.a.dot(in.b), in.a4.dot(in.b4));
    add(found["norm"], in.a2.norm(), in.a.norm(), in.a4.norm());
    add(found["squaredNorm"], (in.a2 - in.b2).squaredNorm(), (in.a - in.b).squaredNorm(),
        (in.a4 - in.b4).squaredNorm(), in.a7.squaredNorm());
    add(found["normalized"], in.a2.normalized(), in.a.normalized(), in.a4.normalized());
    add(found["of floats"], in.a.cast<float>().dot(in.b.cast<float>()), in.a.cast<float>().norm());
    add(found["prod and cross"], in.a.prod(), in.a.cross(in.b));
    add(found["by components"], 0.3 * in.a + in.b / 0.7 - in.a.cwiseProduct(in.b),
        in.a.cwiseMin(in.b).cwiseMax(0.1), in.a.cwiseAbs().sum(), in.a.head<2>().norm());
    add(found["unitOrthogonal"], in.a.unitOrthogonal(), Vec3(0, 0, -2).unitOrthogonal());
    add(found["stableNormalized"], (1e200 * in.a).stableNormalized());
    add(found["array"], Vec3(in.a.array().floor() + 0.5), double((in.a.array() <= in.b.array()).count()));
    add(found["matrix by vector"], in.m * in.a, in.a + in.m * in.a, in.m.transpose() * in.a,
        Mat3(in.m.transpose()) * in.a);
    add(found["matrix by matrix"], in.m * in.n, in.m.transpose() * in.n, in.m * in.n.transpose());
    add(found["inverse"], in.m.inverse(), in.m.determinant(), in.m.trace());
    add(found["sums of matrices"], 0.3 * in.m - in.n / 0.7, Mat3::outerProduct(in.a, in.m * in.a));
    add(found["quaternions"], in.p * in.q, in.p * in.a, in.p.normalized(), in.p.dot(in.q), in.p.inverse());
    add(found["toRotationMatrix"], in.p.toRotationMatrix(), Quaternion(in.p.toRotationMatrix()));
    add(found["FromTwoVectors"], Quaternion::FromTwoVectors(in.a, in.b));
  }
  const std::map<std::string, std::uint64_t> expected = {
      {"sums", 0x8a9d45ba37e9f465},
      {"dot", 0x475ca22e5b15314a},
      {"norm", 0xb3d80ee145108954},
      {"squaredNorm", 0x672c669a103aee95},
      {"normalized", 0x772556f70a843818},
      {"of floats", 0x10b49cb3cbb88254},
      {"prod and cross", 0xbf8d6e22ddbf2bea},
      {"by components", 0x2489b33cbc7a5f88},
      {"unitOrthogonal", 0x2b165ff42174d869},
      {"stableNormalized", 0x3cbad339d6c0fa4f},
      {"array", 0x80e112abdc787d50},
      {"matrix by vector", 0x885e5a5085f7a926},
      {"matrix by matrix", 0x79ec4ec79f04ba53},
      {"inverse", 0xa5ff00d38204e120},
      {"sums of matrices", 0x3a8049500bfda3b3},
      {"quaternions", 0x9976864c00205c46},
      {"toRotationMatrix", 0xaaef25500561c8ff},
      {"FromTwoVectors", 0x189d855735aa52f8},
  };
  REQUIRE(found.size() == expected.size());
  for (const auto& [name, hash] : found) {
    CAPTURE(name);
    CHECK(hash.value() == expected.at(name));
  }
  // These call the sine and the arc tangent of the system.
  const Input in;
  const Vec3 axis = in.a.normalized();
  const double half = 0.5 * in.b.x();
  CHECK(Quaternion::around(axis, in.b.x()).vec() == std::sin(half) * axis);
  CHECK(Quaternion::around(axis, in.b.x()).w() == std::cos(half));
  const Quaternion between = in.p * in.q.conjugate();
  CHECK(in.p.angularDistance(in.q) == 2.0 * std::atan2(between.vec().norm(), std::abs(between.w())));
  // The first of the largest and smallest.
  for (const auto& [v, most, least] :
       {std::tuple(Vec3(1, 3, 2), 1, 0), {Vec3(2, 2, 1), 0, 2}, {Vec3(1, 2, 2), 1, 0}}) {
    int at = -1;
    CHECK((v.maxCoeff(&at) == v[most] && at == most));
    CHECK((v.minCoeff(&at) == v[least] && at == least));
  }
}

TEST_CASE("Opposite vectors are turned into one another", "[vector]") {
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const Vec3 v = side * Vec3::Unit(axis);
      const Quaternion half = Quaternion::FromTwoVectors(v, -v);
      REQUIRE(half.w() == 0.0);
      REQUIRE(half * v == -v);
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
