// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/chord_planes.h"

#include "packMesh/certificate/certificate.h"
#include "packMesh/certificate/certifier.h"
#include "packMesh/core/random.h"
#include "tests/support/catch.h"
#include "tests/support/growing.h"
#include "tests/support/physics.h"
#include "tests/support/shapes.h"

using namespace packmesh;

namespace {

/// A few cells of a shape at random places of a container, scaled so that they do not meet.
struct Arrangement {
  std::shared_ptr<const Shape> shape;
  Physics physics;
  std::vector<Body> state;

  Arrangement(std::shared_ptr<const Shape> of, std::shared_ptr<const Container> in, int cells, double scale)
      : shape(std::move(of)), physics(test::physicsOf({shape}, std::move(in))) {
    state = test::seeded(physics, {cells}, scale);
  }
  PlaneConstraints planes(double reach) const {
    ChordPlanes chords(physics);
    return test::planesOf(chords, physics, state, reach);
  }
};

/// Planes are in single precision: this is more than what rounding changes [µm].
constexpr double rounding = 1e-5;

/// How far the vertex is behind its plane; negative: beyond it [µm].
double room(const Pose& pose, const PlaneConstraint& plane) {
  return plane.normal.dot(plane.point - pose.placement()(plane.vertex));
}

}  // namespace

TEST_CASE("Every vertex is behind its planes") {
  for (const auto& [name, shape] : test::allShapes()) {
    for (const bool periodic : {true, false}) {
      CAPTURE(name, periodic);
      const double edge = 9.0 * shape->radius();
      const Arrangement a(shape, test::cubicBox(edge, periodic), 12, 0.9);
      const PlaneConstraints planes = a.planes(shape->radius());
      std::size_t count = 0;
      for (std::size_t i = 0; i < planes.size(); ++i)
        for (const PlaneConstraint& plane : planes[i]) {
          ++count;
          REQUIRE(plane.normal.norm() == Approx(1.0));
          REQUIRE(room(a.state[i].pose(), plane) >= -rounding);
        }
      CHECK(count > 50);
    }
  }
}

TEST_CASE("Planes of two cells lie in the middle of the gap between them") {
  // Two spheres on a line: all planes are tangent to a surface between them, the nearest one across the line.
  Arrangement a(test::sphereShape(1.0), test::cubicBox(20.0, true), 2, 0.5);
  a.state[0].setPose({1.0, Quaternion::Identity(), Vec3(5.0, 5.0, 5.0)});
  a.state[1].setPose({0.5, Quaternion::Identity(), Vec3(7.0, 5.0, 5.0)});
  const PlaneConstraints planes = a.planes(0.5);
  double nearest = 1e30;
  for (const PlaneConstraint& plane : planes[0]) nearest = std::min(nearest, room(a.state[0].pose(), plane));
  CHECK(nearest == Approx(0.25).margin(0.01));
  // What bounds one bounds the other, at the same plane.
  REQUIRE(planes[0].size() == planes[1].size());
  for (std::size_t k = 0; k < planes[0].size(); ++k) {
    CHECK(std::abs(planes[0][k].normal.dot(planes[0][k].point - planes[1][k].point)) < rounding);
    CHECK(planes[0][k].normal == -planes[1][k].normal);
  }
}

TEST_CASE("Images are neighbours") {
  Arrangement a(test::sphereShape(1.0), test::cubicBox(10.0, true), 2, 0.5);
  a.state[0].setPose({1.0, Quaternion::Identity(), Vec3(0.5, 5.0, 5.0)});
  a.state[1].setPose({1.0, Quaternion::Identity(), Vec3(8.0, 5.0, 5.0)});
  const PlaneConstraints planes = a.planes(0.5);
  REQUIRE(!planes[0].empty());
  for (const PlaneConstraint& plane : planes[0]) CHECK(plane.normal.x() < -0.5);
  for (const PlaneConstraint& plane : planes[1]) CHECK(plane.normal.x() > 0.5);
  CHECK(planes[0][0].point.x() < 0.0);
  CHECK(planes[1][0].point.x() > 8.5);
}

TEST_CASE("Steps limited by planes keep meshes separate") {
  // Cells pushed as far as their planes allow, all at once, in random directions.
  for (const auto& [name, shape] : test::allShapes()) {
    CAPTURE(name);
    const Arrangement a(shape, test::cubicBox(4.2 * shape->radius(), true), 16, 0.55);
    const double reach = 0.4 * shape->radius();
    const PlaneConstraints planes = a.planes(reach);
    int overlaps = 0, held = 0;
    for (std::uint32_t trial = 0; trial < 20; ++trial) {
      std::vector<PlacedCell> cells;
      for (std::size_t i = 0; i < a.state.size(); ++i) {
        const auto u = uniform4(9, RandomStream::kick, i, trial);
        const Vec3 direction = uniformDirection(u[0], u[1]);
        double far = reach;
        for (const PlaneConstraint& plane : planes[i]) {
          const double along = plane.normal.dot(direction);
          if (along > 0.0) far = std::min(far, room(a.state[i].pose(), plane) / along);
        }
        held += far < reach;
        Pose pose = a.state[i].pose();
        pose.position += std::max(0.0, far - 0.0025) * direction;
        cells.push_back({0, 0, pose.placement()});
      }
      overlaps += int(findOverlaps(certificateInputOf(a.physics, cells)).size());
    }
    CHECK(overlaps == 0);
    CHECK(held > 0);
  }
}

TEST_CASE("Walls have several planes along edges and inward curves") {
  Arrangement corner(test::sphereShape(1.0), test::cubicBox(10.0, false), 1, 0.5);
  corner.state[0].setPose({1.0, Quaternion::Identity(), Vec3(1.2, 1.2, 1.2)});
  const PlaneConstraints planes = corner.planes(1.0);
  bool seen[3] = {false, false, false};
  for (const PlaneConstraint& plane : planes[0])
    for (int k = 0; k < 3; ++k)
      if ((plane.normal + Vec3::Unit(k)).norm() < rounding) {
        CHECK(plane.point[k] == Approx(0.0).margin(rounding));
        seen[k] = true;
      }
  CHECK((seen[0] && seen[1] && seen[2]));
  // The vertex that is as far from all three walls has planes of more than one.
  const PlaneConstraint* lowest = &planes[0][0];
  for (const PlaneConstraint& plane : planes[0])
    if (plane.vertex.sum() < lowest->vertex.sum()) lowest = &plane;
  int own = 0;
  for (const PlaneConstraint& plane : planes[0]) own += plane.vertex == lowest->vertex;
  CHECK(own >= 2);

  Arrangement inside(test::sphereShape(1.0), makeSphere(Vec3::Zero(), 4.0), 1, 0.5);
  inside.state[0].setPose({1.0, Quaternion::Identity(), Vec3(2.5, 0.0, 0.0)});
  const PlaneConstraints tangent = inside.planes(0.5);
  CHECK(!tangent[0].empty());
  for (const PlaneConstraint& plane : tangent[0]) {
    // Tangent planes of the sphere: they do not cut it.
    CHECK(plane.normal.dot(plane.point) == Approx(4.0).epsilon(1e-6));
    CHECK(room(inside.state[0].pose(), plane) > 0.0);
  }
}

TEST_CASE("Clearance to the wall moves its planes inwards") {
  Arrangement a(test::sphereShape(1.0), test::cubicBox(10.0, false), 1, 0.5);
  a.state[0].setPose({1.0, Quaternion::Identity(), Vec3(1.5, 5.0, 5.0)});
  a.physics.wallClearance = 0.25;
  const PlaneConstraints planes = a.planes(1.0);
  REQUIRE(!planes[0].empty());
  for (const PlaneConstraint& plane : planes[0]) CHECK(plane.point.x() == Approx(0.25));
}

TEST_CASE("Chords reach the requested distance, with fewer vertices at lower detail") {
  const auto cell = test::redCellShape();
  const Arrangement a(cell, test::cubicBox(25.0, true), 20, 0.5);
  ChordPlanes chords(a.physics);
  const auto count = [&](double reach, double detail) {
    std::size_t sum = 0;
    for (const auto& of : test::planesOf(chords, a.physics, a.state, reach, detail)) sum += of.size();
    return sum;
  };
  CHECK(count(0.0, 1.0) == 0);
  CHECK(count(1.0, 1.0) > 0);
  CHECK(count(2.0, 1.0) > 2 * count(1.0, 1.0));
  const double ratio = double(count(2.0, 1.0)) / double(count(2.0, 0.25));
  CHECK(ratio > 3.0);
  CHECK(ratio < 5.0);
}

TEST_CASE("Frozen cells have no planes and leave the whole gap to others") {
  for (const double clearance : {0.0, 0.1}) {
    Arrangement a(test::sphereShape(1.0), test::cubicBox(20.0, true), 2, 0.5);
    a.physics.clearance = clearance;
    a.state[0].setPose({1.0, Quaternion::Identity(), Vec3(5.0, 5.0, 5.0)});
    a.state[1].setPose({0.5, Quaternion::Identity(), Vec3(7.0, 5.0, 5.0)});
    for (const int frozen : {0, 1}) {
      a.state[frozen].frozen = true;
      a.state[1 - frozen].frozen = false;
      const PlaneConstraints planes = a.planes(0.7);
      CHECK(planes[frozen].empty());
      double nearest = 1e30;
      for (const PlaneConstraint& plane : planes[1 - frozen])
        nearest = std::min(nearest, room(a.state[1 - frozen].pose(), plane));
      // Growth keeps half of the clearance itself.
      CHECK(nearest == Approx(0.5 - 0.5 * clearance).margin(0.01));
    }
    a.state[0].frozen = a.state[1].frozen = true;
    CHECK(a.planes(0.7)[0].empty());
  }
}
