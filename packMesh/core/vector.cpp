// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/vector.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <charconv>

namespace packmesh {

Quaternion::Quaternion(const Mat3& m) {
  const double trace = m.trace();
  if (trace > 0.0) {
    const double twice = std::sqrt(trace + 1.0), s = 0.5 / twice;
    *this = {0.5 * twice, (m(2, 1) - m(1, 2)) * s, (m(0, 2) - m(2, 0)) * s, (m(1, 0) - m(0, 1)) * s};
    return;
  }
  int i = m(1, 1) > m(0, 0) ? 1 : 0;
  if (m(2, 2) > m(i, i)) i = 2;
  const int j = (i + 1) % 3, k = (j + 1) % 3;
  const double twice = std::sqrt(m(i, i) - m(j, j) - m(k, k) + 1.0), s = 0.5 / twice;
  c_[i] = 0.5 * twice;
  c_[j] = (m(j, i) + m(i, j)) * s;
  c_[k] = (m(k, i) + m(i, k)) * s;
  w() = (m(k, j) - m(j, k)) * s;
}

Quaternion Quaternion::around(const Vec3& axis, double angle) {
  const Vec3 v = std::sin(0.5 * angle) * axis;
  return {std::cos(0.5 * angle), v.x(), v.y(), v.z()};
}

Quaternion Quaternion::FromTwoVectors(const Vec3& from, const Vec3& to) {
  const Vec3 a = from.normalized(), b = to.normalized();
  const double cosine = b.dot(a);
  if (cosine < -1.0 + aboutEqual) {
    // About opposite: half a turn around what a reflection that maps a to the x axis maps to the z axis.
    const double side = a.x() < 0.0 ? -1.0 : 1.0;
    const Vec3 axis = Vec3::UnitZ() - a.z() / (1.0 + std::abs(a.x())) * (a + side * Vec3::UnitX());
    const double w2 = 0.5 * (1.0 + std::max(cosine, -1.0));
    const Vec3 v = axis * std::sqrt(1.0 - w2);
    return {std::sqrt(w2), v.x(), v.y(), v.z()};
  }
  const double s = std::sqrt((1.0 + cosine) * 2.0);
  const Vec3 v = a.cross(b) * (1.0 / s);
  return {0.5 * s, v.x(), v.y(), v.z()};
}

PrincipalAxes principalAxes(const Mat3& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      Eigen::Map<const Eigen::Matrix3d>(symmetric.data()));
  return {solver.eigenvalues(), Mat3(solver.eigenvectors())};
}

std::string toText(double value, int digits) {
  char text[64];
  return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, digits).ptr};
}

std::string toText(const Vec3& p) {
  return "(" + toText(p.x()) + ", " + toText(p.y()) + ", " + toText(p.z()) + ")";
}

}  // namespace packmesh
