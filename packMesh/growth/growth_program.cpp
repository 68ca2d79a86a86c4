// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/growth_program.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace packmesh {
namespace {

/// Factor by which the displacement of vertices can exceed its first-order approximation, for θ_max up to
/// π/12.
constexpr double secondOrder = 1.3;

/// Rows that keep the axis of a cell in its cone.
constexpr int rowsOfCone = 5;

/// Rotation by `r` as in GrowthStep.
Quaternion quaternionOf(const Vec3& r) {
  return Quaternion(1.0, 0.5 * r.x(), 0.5 * r.y(), 0.5 * r.z()).normalized();
}

/// The inverse of quaternionOf(). Pre: less than half a turn
Vec3 vectorOf(const Quaternion& q) {
  return 2.0 / q.w() * q.vec();
}

}  // namespace

Pose stepped(const Pose& pose, const GrowthStep& step, double fraction, const AxisCone* cone) {
  if (fraction == 0.0) return pose;
  Pose out = pose;
  out.scale = fraction == 1.0 ? step.scale : pose.scale + fraction * (step.scale - pose.scale);
  if (!step.rotation.isZero(0.0)) {
    out.orientation = (quaternionOf(fraction * step.rotation) * pose.orientation).normalized();
    if (cone) out.orientation = cone->nearest(out.orientation);
  }
  out.position += fraction * step.translation;
  return out;
}

/// The planes that a step within the bounds could reach.
void GrowthProgram::takeRows(const Pose& pose, const std::vector<PlaneConstraint>& planes,
                             const GrowthBounds& bounds) {
  rows_.clear();
  rows_.reserve(planes.size());
  const Mat3 rotation = pose.orientation.toRotationMatrix();
  axis_ = rotation * Vec3::UnitY();
  for (const PlaneConstraint& plane : planes) {
    const Vec3 arm = rotation * plane.vertex;
    const double toPlane = plane.normal.dot(plane.point - pose.position);
    const double along = plane.normal.dot(arm), now = pose.scale * along;
    const double limit = std::max(toPlane - bounds.padding, now);
    const double most = std::max(now, bounds.scale * along) + bounds.translation * plane.normal.lpNorm<1>() +
                        secondOrder * bounds.rotation * bounds.scale * arm.cross(plane.normal).lpNorm<1>();
    if (most + bounds.margin > limit) rows_.push_back({arm, plane.normal, limit});
  }
}

/// Least distance of any vertex from its limit if the cell only grows [µm].
double GrowthProgram::roomAt(double scale) const {
  double room = std::numeric_limits<double>::infinity();
  for (const Row& row : rows_) room = std::min(room, row.limit - scale * row.normal.dot(row.arm));
  return room;
}

/// Solves the programme linearised around `step`. The variables are the scale (at the barrier: the margin),
/// the rotation relative to that of the step, and the translation. false: there is no solution.
bool GrowthProgram::improve(const GrowthBounds& bounds, bool atBarrier, GrowthStep& step) {
  const Quaternion turned = quaternionOf(step.rotation);
  const Mat3 rotation = turned.toRotationMatrix();
  program_.clear(static_cast<int>(rows_.size()) + rowsOfCone);
  LinearProgram::Vector a;
  for (const Row& row : rows_) {
    const Vec3 arm = rotation * row.arm;
    const double along = row.normal.dot(arm);
    a[0] = atBarrier ? 1.0 : along;
    a.segment<3>(1) = step.scale * arm.cross(row.normal);
    a.segment<3>(4) = row.normal;
    program_.addRow(a, atBarrier ? row.limit - bounds.scale * along : row.limit);
  }
  if (bounds.cone) addCone(*bounds.cone, rotation);
  program_.objective << 1.0, bounds.turn, bounds.push;
  program_.lower << 0.0, Vec3::Constant(-bounds.rotation) - step.rotation,
      Vec3::Constant(-bounds.translation);
  program_.upper << (atBarrier ? bounds.margin : bounds.scale),
      Vec3::Constant(bounds.rotation) - step.rotation, Vec3::Constant(bounds.translation);
  const LinearProgram::Solution solution = program_.solve();
  pivots_ += solution.pivots;
  if (solution.status != LinearProgram::Status::optimal) return false;
  if (!atBarrier) step.scale = std::min(solution.x[0], bounds.scale);
  if (bounds.rotation > 0.0) step.rotation = vectorOf(quaternionOf(solution.x.segment<3>(1)) * turned);
  step.translation = solution.x.segment<3>(4);
  return true;
}

/// Rotations r that keep the axis a, rotated so far by `rotation`, in the cone around c, to first order: (a +
/// r x a) · c >= cos(spread). In a narrow cone this is no constraint where a = c: there neither component of
/// r perpendicular to the axis may exceed twice the spread.
void GrowthProgram::addCone(const AxisCone& cone, const Mat3& rotation) {
  const Vec3 a = rotation * axis_;
  const Vec3 c = a.dot(cone.axis) < 0.0 ? Vec3(-cone.axis) : cone.axis;
  LinearProgram::Vector row = LinearProgram::Vector::Zero();
  row.segment<3>(1) = -a.cross(c);
  program_.addRow(row, std::max(0.0, a.dot(c) - std::cos(cone.spread)));
  const Vec3 u = a.unitOrthogonal(), v = a.cross(u);
  for (const Vec3& across : {u, Vec3(-u), v, Vec3(-v)}) {
    row.segment<3>(1) = across;
    program_.addRow(row, 2.0 * cone.spread);
  }
}

GrowthStep GrowthProgram::solve(const Pose& pose, const std::vector<PlaneConstraint>& planes,
                                const GrowthBounds& bounds) {
  takeRows(pose, planes, bounds);
  GrowthStep step;
  step.scale = bounds.scale;
  if (roomAt(bounds.scale) >= bounds.margin) return step;
  step.scale = pose.scale;
  bool atBarrier = roomAt(bounds.scale) >= 0.0;
  for (int k = 0; k < bounds.linearisations && !atBarrier; ++k) {
    if (!improve(bounds, false, step)) break;
    atBarrier = k == 0 && step.scale >= bounds.scale;
  }
  step.scale = std::max(step.scale, pose.scale);  // compensates for linearisation and rounding
  if (!atBarrier || bounds.margin <= 0.0) return step;
  GrowthStep centred;
  centred.scale = bounds.scale;
  for (int k = 0; k < bounds.linearisations; ++k)
    if (!improve(bounds, true, centred)) return step;
  return centred;
}

}  // namespace packmesh
