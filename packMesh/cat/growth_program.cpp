// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/growth_program.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "packMesh/core/tolerances.h"

namespace packmesh {
namespace {

constexpr int atOnce = LinearProgramView::rowsAtOnce;

/// Right-hand side of the rows that fill up.
constexpr double unlimited = 1e300;

int roundedUp(int rows) {
  return (rows + atOnce - 1) / atOnce * atOnce;
}

}  // namespace

void LinearProgram::clear() {
  rows_ = 0;
  contradiction_ = false;
}

void LinearProgram::reserve(int rows) {
  const auto needed = static_cast<std::size_t>(roundedUp(rows));
  if (column_[0].size() >= needed) return;
  for (std::vector<double>& column : column_) column.resize(needed + needed / 2);
}

/// Rows after the last one that restrict nothing.
void LinearProgram::fillUp() {
  for (int k = 0; k <= size; ++k)
    std::fill(column_[k].begin() + rows_, column_[k].begin() + roundedUp(rows_), k == size ? unlimited : 0.0);
}

std::array<double*, LinearProgram::size + 1> LinearProgram::room(int more) {
  reserve(rows_ + more + atOnce);
  std::array<double*, size + 1> out;
  for (int k = 0; k <= size; ++k) out[k] = column_[k].data() + rows_;
  return out;
}

void LinearProgram::grow(int more) {
  rows_ += more;
  fillUp();
}

void LinearProgram::addRow(const Vector& a, double b) {
  const double square = a.squaredNorm();
  if (!(square > 0.0)) {
    contradiction_ = contradiction_ || b < -accuracy;
    return;
  }
  const std::array<double*, size + 1> row = room(1);
  const double scale = 1.0 / std::sqrt(square);
  for (int j = 0; j < size; ++j) *row[j] = scale * a[j];
  *row[size] = scale * b;
  grow(1);
}

LinearProgram::Solution LinearProgram::solve() const {
  Solution solution;
  if (contradiction_) {
    solution.status = Status::infeasible;
    return solution;
  }
  LinearProgramView view;
  for (int j = 0; j < size; ++j) {
    view.column[j] = column_[j].data();
    view.objective[j] = objective[j];
    view.lower[j] = lower[j];
    view.upper[j] = upper[j];
  }
  view.rhs = column_[size].data();
  view.rows = rows_;
  LinearProgramResult result;
  kernel_(view, accuracy, result);
  solution.status = result.status;
  solution.pivots = result.pivots;
  for (int j = 0; j < size; ++j) solution.x[j] = result.x[j];
  return solution;
}

namespace {

/// Factor by which the displacement of vertices can exceed its first-order approximation, for θ_max up to
/// π/12.
constexpr double secondOrder = 1.3;

/// The seven variables.
LinearProgram::Vector variables(double scale, const Vec3& r, const Vec3& t) {
  const double all[] = {scale, r.x(), r.y(), r.z(), t.x(), t.y(), t.z()};
  return LinearProgram::Vector(all);
}

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
void GrowthProgram::takeReached(const Pose& pose, const CellPlanes& planes, const GrowthBounds& bounds) {
  const StepReach reach{static_cast<float>(pose.scale),
                        static_cast<float>(bounds.scale),
                        static_cast<float>(bounds.padding),
                        static_cast<float>(bounds.translation),
                        static_cast<float>(secondOrder * bounds.rotation),
                        static_cast<float>(bounds.margin)};
  std::array<const float*, CellPlanes::columns> from;
  for (int k = 0; k < CellPlanes::columns; ++k) from[k] = planes.column(k);
  reached_.clear();
  const std::array<float*, CellPlanes::columns> to = reached_.room(planes.size());
  reached_.grow(kernel_.reached(from.data(), static_cast<int>(planes.size()), reach, to.data(), room_));
  axis_ = pose.orientation * Vec3::UnitY();
}

/// Solves the programme linearised around `step`. The variables are the scale (at the barrier: the margin),
/// the rotation relative to that of the step, and the translation. false: there is no solution.
bool GrowthProgram::improve(const GrowthBounds& bounds, bool atBarrier, GrowthStep& step) {
  const Quaternion turned = quaternionOf(step.rotation);
  const Mat3 rotation = turned.toRotationMatrix();
  program_.clear();
  program_.accuracy = tolerance::singlePrecisionProgram;
  const auto count = static_cast<int>(reached_.size());
  std::array<const float*, CellPlanes::columns> from;
  for (int k = 0; k < CellPlanes::columns; ++k) from[k] = reached_.column(k);
  float matrix[9];
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) matrix[3 * r + c] = static_cast<float>(rotation(r, c));
  kernel_.rows(from.data(), count, matrix, static_cast<float>(step.scale), atBarrier,
               program_.room(count).data());
  program_.grow(count);
  if (bounds.cone) addCone(*bounds.cone, rotation);
  program_.objective = variables(1.0, bounds.turn, bounds.push);
  program_.lower =
      variables(0.0, Vec3::Constant(-bounds.rotation) - step.rotation, Vec3::Constant(-bounds.translation));
  program_.upper =
      variables(atBarrier ? bounds.margin : bounds.scale, Vec3::Constant(bounds.rotation) - step.rotation,
                Vec3::Constant(bounds.translation));
  const LinearProgram::Solution solution = program_.solve();
  pivots_ += solution.pivots;
  if (solution.status != LinearProgram::Status::optimal) return false;
  const LinearProgram::Vector x = solution.x.cwiseMax(program_.lower).cwiseMin(program_.upper);
  if (!atBarrier) step.scale = x[0];
  if (bounds.rotation > 0.0) step.rotation = vectorOf(quaternionOf(x.head<4>().tail<3>()) * turned);
  step.translation = x.tail<3>();
  return true;
}

/// Rotations r that keep the axis a, rotated so far by `rotation`, in the cone around c, to first order: (a +
/// r x a) · c >= cos(spread). In a narrow cone this is no constraint where a = c: there neither component of
/// r perpendicular to the axis may exceed twice the spread.
void GrowthProgram::addCone(const AxisCone& cone, const Mat3& rotation) {
  const Vec3 a = rotation * axis_;
  const Vec3 c = a.dot(cone.axis) < 0.0 ? Vec3(-cone.axis) : cone.axis;
  program_.addRow(variables(0.0, -a.cross(c), Vec3::Zero()), std::max(0.0, a.dot(c) - std::cos(cone.spread)));
  const Vec3 u = a.unitOrthogonal(), v = a.cross(u);
  for (const Vec3& across : {u, -u, v, -v})
    program_.addRow(variables(0.0, across, Vec3::Zero()), 2.0 * cone.spread);
}

GrowthStep GrowthProgram::solve(const Pose& pose, const CellPlanes& planes, const GrowthBounds& bounds) {
  takeReached(pose, planes, bounds);
  GrowthStep step;
  step.scale = bounds.scale;
  if (room_ >= bounds.margin) return step;
  step.scale = pose.scale;
  bool atBarrier = room_ >= 0.0f;
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
