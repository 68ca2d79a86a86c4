// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/pos_file.h"

#include <charconv>
#include <cmath>
#include <stdexcept>

namespace packmesh::hemocell {
namespace {

constexpr double degree = 3.14159265358979323846 / 180.0;

/// -0 would be written as "-0".
double withoutNegativeZero(double x) {
  return x == 0.0 ? 0.0 : x;
}

void append(std::string& text, double value) {
  if (!std::isfinite(value))
    throw std::invalid_argument("a .pos file cannot hold numbers that are not finite");
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, withoutNegativeZero(value)).ptr;
  text.append(digits, end);
}

}  // namespace

Placement placementOf(const PosLine& line) {
  const Vec3 angle = degree * line.angles;
  const double sa = std::sin(angle.x()), ca = std::cos(angle.x());
  const double sb = std::sin(angle.y()), cb = std::cos(angle.y());
  const double sc = std::sin(angle.z()), cc = std::cos(angle.z());
  Placement placement;
  // Rz(c)·Ry(b)·Rx(a), written out.
  placement.linear << cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa,  //
      sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa,                  //
      -sb, cb * sa, cb * ca;
  placement.translation = line.position;
  return placement;
}

Pose poseOf(const PosLine& line) {
  return {1.0, Quaternion(placementOf(line).linear).normalized(), line.position};
}

PosLine posLineOf(const Pose& pose) {
  const Mat3 r = pose.orientation.normalized().toRotationMatrix();
  // c first; then a and b from Rz(-c)·R = Ry(b)·Rx(a), whose entries remain well defined if cos(b) is tiny
  // and c is dominated by noise: a and b are consistent with any c.
  const double c = std::atan2(r(1, 0), r(0, 0));
  const double sc = std::sin(c), cc = std::cos(c);
  const double b = std::atan2(-r(2, 0), cc * r(0, 0) + sc * r(1, 0));
  const double a = std::atan2(sc * r(0, 2) - cc * r(1, 2), cc * r(1, 1) - sc * r(0, 1));
  PosLine line{pose.position, Vec3(a, b, c) / degree};
  for (int k = 0; k < 3; ++k) {
    line.position[k] = withoutNegativeZero(line.position[k]);
    line.angles[k] = withoutNegativeZero(line.angles[k]);
  }
  return line;
}

std::string formatPosHead(std::int64_t count) {
  return std::to_string(count) + '\n';
}

std::string formatPosLines(const std::vector<PosLine>& lines) {
  std::string text;
  text.reserve(110 * lines.size());
  for (const PosLine& line : lines)
    for (int k = 0; k < 6; ++k) {
      append(text, k < 3 ? line.position[k] : line.angles[k - 3]);
      text += k < 5 ? ' ' : '\n';
    }
  return text;
}

}  // namespace packmesh::hemocell
