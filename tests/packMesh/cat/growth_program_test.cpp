// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/growth_program.h"

#include "tests/packMesh/mesh/test_meshes.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

/// Planes of a box, for each vertex of a mesh.
std::vector<PlaneConstraint> boxPlanes(const TriangleMesh& mesh, const Box& box) {
  std::vector<PlaneConstraint> planes;
  for (const Vec3& v : mesh.vertices)
    for (int k = 0; k < 3; ++k) {
      planes.push_back({v, box.hi, Vec3::Unit(k)});
      planes.push_back({v, box.lo, -Vec3::Unit(k)});
    }
  return planes;
}

/// How far the furthest vertex is beyond its plane [µm].
double worst(const Pose& pose, const std::vector<PlaneConstraint>& planes) {
  double most = -1e30;
  for (const PlaneConstraint& p : planes)
    most = std::max(most, p.normal.dot(pose.placement()(p.vertex) - p.point));
  return most;
}

GrowthStep solved(GrowthProgram& program, const Pose& pose, const std::vector<PlaneConstraint>& constraints,
                  const GrowthBounds& bounds) {
  CellPlanes planes;
  for (const PlaneConstraint& plane : constraints) planes.add(pose, plane);
  return program.solve(pose, planes, bounds);
}
GrowthStep solved(const Pose& pose, const std::vector<PlaneConstraint>& constraints,
                  const GrowthBounds& bounds) {
  GrowthProgram program;
  return solved(program, pose, constraints, bounds);
}

GrowthBounds wideBounds() {
  GrowthBounds bounds;
  bounds.scale = 10.0;
  bounds.rotation = 0.2;
  bounds.translation = 0.5;
  bounds.linearisations = 3;
  return bounds;
}

const TriangleMesh cornerCube = sample::box(Vec3::Constant(-1.0), Vec3::Constant(1.0));

}  // namespace

TEST_CASE("An off-centre cube in a larger one moves to the centre and fills it") {
  const auto planes = boxPlanes(cornerCube, {Vec3::Constant(-1.0), Vec3::Constant(1.0)});
  Pose pose{0.5, Quaternion::Identity(), Vec3(0.3, -0.2, 0.1)};
  const GrowthStep step = solved(pose, planes, wideBounds());
  CHECK(step.scale == Approx(1.0));
  CHECK((pose.position + step.translation).norm() < 1e-6);  // planes are in single precision
}

TEST_CASE("A rotated cube rotates back and fills the box step by step") {
  std::mt19937 random(3);
  for (int n = 0; n < 10; ++n) {
    const auto planes = boxPlanes(cornerCube, {Vec3::Constant(-1.0), Vec3::Constant(1.0)});
    Pose pose{0.3, Quaternion(test::randomRotation(random)), 0.2 * test::randomDirection(random)};
    GrowthProgram program;
    double scale = pose.scale;
    for (int i = 0; i < 40 && pose.scale < 0.999; ++i) {
      pose = stepped(pose, solved(program, pose, planes, wideBounds()));
      CHECK(pose.scale >= scale - 1e-9);
      scale = pose.scale;
      // Linearising the rotation costs at most its second order.
      CHECK(worst(pose, planes) < 0.02);
    }
    CHECK(pose.scale > 0.99);
  }
}

TEST_CASE("Growth stays within its bounds and its padding") {
  std::mt19937 random(4);
  const TriangleMesh cell = test::redCell(2);
  int atBound = 0;
  for (int n = 0; n < 50; ++n) {
    const Box box{Vec3::Constant(-3.0), Vec3::Constant(3.0)};
    const auto planes = boxPlanes(cell, box);
    const Pose pose{0.5, Quaternion(test::randomRotation(random)), 0.3 * test::randomDirection(random)};
    GrowthBounds bounds = wideBounds();
    bounds.scale = n % 2 ? 0.6 : 3.0;
    bounds.rotation = 0.05;
    bounds.translation = 0.15;
    bounds.padding = 0.1;
    const GrowthStep step = solved(pose, planes, bounds);
    CHECK(step.scale <= bounds.scale);
    CHECK(step.scale >= pose.scale);
    CHECK(step.translation.cwiseAbs().maxCoeff() <= bounds.translation + 1e-9);
    const Quaternion turn = stepped(pose, step).orientation * pose.orientation.conjugate();
    // About each axis; linearised anew, the rotation may exceed its bound by the second order.
    const double turned = 2.0 * turn.vec().cwiseAbs().maxCoeff() / std::abs(turn.w());
    CHECK(turned <= 1.05 * bounds.rotation);
    atBound += turned > 0.99 * bounds.rotation;
    CHECK(worst(stepped(pose, step), planes) < -bounds.padding + 0.005);
  }
  CHECK(atBound > 0);  // the bound of the rotation does hold cells back
}

TEST_CASE("A cell whose padding is violated can stay, but not move closer") {
  const auto planes = boxPlanes(cornerCube, {Vec3::Constant(-1.0), Vec3::Constant(1.0)});
  const Pose pose{0.9, Quaternion::Identity(), Vec3(0.09, 0.0, 0.0)};  // 0.01 from the plane at x = 1
  GrowthBounds bounds = wideBounds();
  bounds.padding = 0.05;
  bounds.translation = 0.0;
  const GrowthStep step = solved(pose, planes, bounds);
  CHECK(step.scale == Approx(0.9));
  bounds.translation = 0.2;
  CHECK(solved(pose, planes, bounds).scale > 0.92);
}

TEST_CASE("A cell at the barrier moves to the centre of its planes") {
  const auto planes = boxPlanes(cornerCube, {Vec3::Constant(-1.0), Vec3::Constant(1.0)});
  const Pose pose{0.5, Quaternion::Identity(), Vec3(0.4, -0.3, 0.2)};
  GrowthBounds bounds = wideBounds();
  bounds.scale = 0.6;
  bounds.margin = 1.0;
  const GrowthStep step = solved(pose, planes, bounds);
  CHECK(step.scale == 0.6);
  CHECK((pose.position + step.translation).norm() < 1e-6);
  // Nothing to do where there is room enough.
  bounds.margin = 0.05;
  const Pose middle{0.5, Quaternion::Identity(), Vec3(0.1, 0.0, 0.0)};
  const GrowthStep still = solved(middle, planes, bounds);
  CHECK(still.scale == 0.6);
  CHECK(still.translation.isZero(0.0));
  CHECK(still.rotation.isZero(0.0));
}

TEST_CASE("A cell without planes grows to the barrier in place") {
  GrowthBounds bounds = wideBounds();
  bounds.scale = 0.7;
  bounds.margin = 0.3;
  const GrowthStep step = solved(Pose{0.1, Quaternion::Identity(), Vec3::Zero()}, {}, bounds);
  CHECK(step.scale == 0.7);
  CHECK(step.translation.isZero(0.0));
}

TEST_CASE("Partial steps scale translation, rotation and growth") {
  std::mt19937 random(5);
  const Pose pose{0.4, Quaternion(test::randomRotation(random)), Vec3(1.0, 2.0, 3.0)};
  GrowthStep step;
  step.scale = 0.8;
  step.rotation = Vec3(0.1, -0.2, 0.05);
  step.translation = Vec3(0.0, 1.0, 0.0);
  const Pose none = stepped(pose, step, 0.0);
  CHECK(none.scale == pose.scale);
  CHECK(none.position == pose.position);
  CHECK(none.orientation.coeffs() == pose.orientation.coeffs());
  const Pose half = stepped(pose, step, 0.5), whole = stepped(pose, step);
  CHECK(half.scale == Approx(0.6));
  CHECK(half.position.y() == Approx(2.5));
  CHECK(whole.scale == 0.8);
  CHECK(half.orientation.angularDistance(pose.orientation) ==
        Approx(whole.orientation.angularDistance(half.orientation)).epsilon(0.02));
}
