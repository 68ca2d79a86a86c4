// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/shape/shape.h"
#include "packMesh/shape/surface_distance.h"
#include "tests/support/catch.h"
#include "tests/support/deformed.h"
#include "tests/support/shapes.h"

using namespace packmesh;

TEST_CASE("A deformed shape has the exact tests of its mesh, and bounds around it", "[shape]") {
  const std::shared_ptr<const Shape> red = test::redCellShape();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> within(-1.0, 1.0);
  int meeting = 0, near = 0;
  for (int n = 0; n < 150; ++n) {
    const Shape a(test::deformed(red->mesh(), n), red), b(test::deformed(red->mesh(), n + 1000), red);
    const MeshHierarchy fullA(a.mesh()), fullB(b.mesh());
    Pose pose;
    pose.orientation =
        Quaternion(within(random), within(random), within(random), within(random)).normalized();
    pose.position = 6.0 * Vec3(within(random), within(random), within(random));
    const Placement other = pose.placement();
    const MeshPairResult own = relate(a.hierarchy(), Placement(), b.hierarchy(), other, 1.0),
                         expected = relate(fullA, Placement(), fullB, other, 1.0);
    REQUIRE(own.relation == expected.relation);
    REQUIRE(own.gap == expected.gap);
    CHECK(boundingSphere(a.sphere(), other).center == boundingSphere(a.hierarchy(), other).center);
    CHECK(boundingSphere(a.sphere(), other).radius == boundingSphere(a.hierarchy(), other).radius);
    const std::vector<Vec3>* vertices = &a.mesh().vertices;
    a.forgetHierarchy();
    REQUIRE(&a.mesh().vertices == vertices);  // the mesh stays
    REQUIRE(relate(a.hierarchy(), Placement(), b.hierarchy(), other, 1.0).gap == expected.gap);
    const MeshPairResult mixed = relate(red->hierarchy(), Placement(), b.hierarchy(), other, 1.0);
    REQUIRE(mixed.gap == relate(red->hierarchy(), Placement(), fullB, other, 1.0).gap);
    meeting += own.relation == MeshRelation::meet;
    near += own.gap > 0.0 && own.gap < 1.0;
    const Vec3 direction = Vec3(within(random), within(random), within(random)).normalized();
    for (const Vec3& v : a.mesh().vertices) {
      REQUIRE(v.dot(direction) <= a.bound().support(direction) + 1e-9);
      REQUIRE(v.norm() <= a.radius());
    }
    REQUIRE(a.reach() >= a.radius());
  }
  CHECK(meeting > 20);
  CHECK(near > 10);
}

TEST_CASE("The grid of a deformed shape is near its surface, and its points are inside", "[shape]") {
  const std::shared_ptr<const Shape> red = test::redCellShape();
  for (const int seed : {1, 2, 3}) {
    const Shape shape(test::deformed(red->mesh(), seed), red);
    CHECK(shape.undeformed() == red);
    CHECK(shape.volume() == Approx(signedVolume(shape.mesh())));
    const SurfaceDistance surface(shape);
    double worst = 0.0;
    for (const Vec3& v : shape.mesh().vertices) worst = std::max(worst, std::abs(surface.sample(v).distance));
    CHECK(worst < 0.15);
    int inside = 0;
    const std::vector<Vec3> points = innerPoints(shape, 100);
    for (const Vec3& p : points) inside += isInside(p, shape.hierarchy(), Placement());
    REQUIRE(points.size() == 100);
    CHECK(inside >= 95);
  }
}
