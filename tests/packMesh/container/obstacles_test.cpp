// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/obstacles.h"

#include "packMesh/container/primitives.h"
#include "packMesh/core/error.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

TriangleMesh blockOf(const Vec3& lo, const Vec3& hi) {
  return makeBox({lo, hi}, {false, false, false})->surface();
}

Obstacle cubeObstacle(const Vec3& lo, const Vec3& hi, const std::string& name = "cube") {
  return {blockOf(lo, hi), name};
}

std::shared_ptr<const Container> room(std::array<bool, 3> periodic = {false, false, false}) {
  return makeBox({Vec3(0, 0, 0), Vec3(20, 20, 20)}, periodic);
}

}  // namespace

TEST_CASE("The volume of a mesh inside a box is exact", "[obstacles]") {
  const Box box{Vec3(0, 0, 0), Vec3(10, 10, 10)};
  CHECK(volumeInside(blockOf(Vec3(2, 2, 2), Vec3(4, 5, 6)), box) == Approx(24));
  CHECK(volumeInside(blockOf(Vec3(-2, 2, 2), Vec3(4, 5, 6)), box) == Approx(48));
  CHECK(volumeInside(blockOf(Vec3(2, 2, -50), Vec3(4, 5, 50)), box) == Approx(60));
  CHECK(volumeInside(blockOf(Vec3(-5, -5, -5), Vec3(50, 50, 50)), box) == Approx(1000));
  CHECK(volumeInside(blockOf(Vec3(2, 2, 20), Vec3(4, 5, 50)), box) == Approx(0).margin(1e-9));
  CHECK(volumeInside(blockOf(Vec3(2, 2, -20), Vec3(4, 5, -10)), box) == Approx(0).margin(1e-9));
  const TriangleMesh ball = makeSphere(Vec3(10, 5, 10), 3)->surface();
  CHECK(volumeInside(ball, box) == Approx(signedVolume(ball) / 4).epsilon(0.01));
}

TEST_CASE("An obstacle is a wall, reduces the volume and must not be touched by cells", "[obstacles]") {
  const auto container = subtractObstacles(room(), {cubeObstacle(Vec3(8, 8, -1), Vec3(12, 12, 21))});
  CHECK(container->volume() == Approx(8000 - 16 * 20));
  const Wall* wall = container->wall();
  REQUIRE(wall);
  CHECK(wall->distance(Vec3(7, 10, 10)).distance == Approx(1).margin(0.01));
  CHECK(wall->distance(Vec3(7, 10, 10)).gradient.x() == Approx(-1).margin(0.05));
  CHECK(wall->distance(Vec3(10, 10, 10)).distance < 0);
  CHECK(wall->distance(Vec3(1, 10, 10)).distance == Approx(1).margin(0.01));
  CHECK(wall->distance(Vec3(4, 10, 10)).distance <= 4 + wall->slack());
  CHECK_FALSE(wall->violation(blockOf(Vec3(1, 1, 1), Vec3(3, 3, 3))));
  CHECK_THAT(*wall->violation(blockOf(Vec3(6, 9, 9), Vec3(8, 11, 11))), Contains("obstacle"));
  CHECK_THAT(*wall->violation(blockOf(Vec3(9, 9, 9), Vec3(11, 11, 11))), Contains("obstacle"));
  CHECK(wall->violation(blockOf(Vec3(-1, 1, 1), Vec3(3, 3, 3))));
  CHECK_THAT(container->describe(), Contains("1 obstacle"));
}

TEST_CASE("Obstacles repeat along periodic axes", "[obstacles]") {
  const auto container =
      subtractObstacles(room({true, false, false}), {cubeObstacle(Vec3(-2, 8, 8), Vec3(2, 12, 12))});
  CHECK(container->volume() == Approx(8000 - 64));
  CHECK(container->wall()->distance(Vec3(17, 10, 10)).distance == Approx(1).margin(0.01));
  CHECK(container->wall()->distance(Vec3(19, 10, 10)).distance < 0);
  CHECK(container->wall()->violation(blockOf(Vec3(17, 9, 9), Vec3(19, 11, 11))));
}

TEST_CASE("The wall gap includes obstacles, their images and the wall around them", "[obstacles]") {
  const auto container = subtractObstacles(
      room({true, false, false}),
      {cubeObstacle(Vec3(-2, 8, 8), Vec3(2, 12, 12)), cubeObstacle(Vec3(8, 8, 8), Vec3(10, 10, 10))});
  const MeshHierarchy cell(blockOf(Vec3(-1, -1, -1), Vec3(1, 1, 1)));
  const auto examined = [&](const Vec3& p, double interest) {
    return container->wall()->examine({cell, {Mat3::Identity(), p}}, interest);
  };
  CHECK(examined({3.25, 10, 10}, 1.0).gap == 0.25);
  CHECK(examined({16.5, 10, 10}, 1.0).gap == 0.5);    // an image
  CHECK(examined({23.25, 10, 10}, 1.0).gap == 0.25);  // through the end
  CHECK(examined({6.75, 9, 9}, 1.0).gap == 0.25);
  CHECK(examined({6.75, 9, 9}, 0.2).gap == std::numeric_limits<double>::infinity());
  CHECK(examined({5, 6, 1.125}, 1.0).gap == 0.125);
  CHECK(examined({3.5, 6.5, 10}, 1.0).gap == Approx(std::sqrt(0.5)));
  CHECK(examined({5.0, 10, 10}, 10.0).gap == 2.0);
  CHECK(examined({6.0, 9, 9}, 10.0).gap == 1.0);
  CHECK(examined({7.5, 9, 9}, 1.0).violation == std::string("meets an obstacle"));
  CHECK(examined({0.5, 10, 10}, 1.0).violation == std::string("is inside an obstacle"));
  // What distance() and slack() promise, next to edges and corners too.
  for (const Vec3& p :
       {Vec3(3.9, 13.9, 10), Vec3(3.9, 13.9, 13.9), Vec3(4.4, 10, 10), Vec3(5.03, 6.91, 6.94)})
    for (const double gap : {0.1, 0.3, 0.5, 1.0})
      if (container->wall()->isAway(boundingSphere(cell, {Mat3::Identity(), p}), gap))
        CHECK(examined(p, 10.0).gap > gap);
}

TEST_CASE("Invalid obstacles are rejected", "[obstacles]") {
  CHECK_THROWS_WITH(subtractObstacles(room(), {cubeObstacle(Vec3(30, 0, 0), Vec3(40, 1, 1))}),
                    Contains("outside the lumen"));
  CHECK_THROWS_WITH(subtractObstacles(room(), {cubeObstacle(Vec3(-1, -1, -1), Vec3(21, 21, 21))}),
                    Contains("fill the whole lumen"));
  const auto pipe = std::shared_ptr<const Container>(makeCylinder(Vec3(10, 10, 10), 0, 8, 20, false));
  CHECK_THROWS_WITH(subtractObstacles(pipe, {cubeObstacle(Vec3(1, 2.1, 2.1), Vec3(5, 3, 3))}),
                    Contains("outside the lumen"));
}

TEST_CASE("Overlapping obstacles act as one body in volume, distance, wall test and surface", "[obstacles]") {
  // 4³ + 3³ - 1, and one that lies in the first; a bar through all periods overlaps its own images.
  const auto container = subtractObstacles(room(), {cubeObstacle(Vec3(1, 1, 1), Vec3(5, 5, 5), "a"),
                                                    cubeObstacle(Vec3(4, 4, 4), Vec3(7, 7, 7), "b"),
                                                    cubeObstacle(Vec3(2, 2, 2), Vec3(3, 3, 3), "c")});
  CHECK(container->volume() == Approx(8000 - 64 - 27 + 1).margin(0.8));
  const Wall* wall = container->wall();
  CHECK(wall->distance(Vec3(5.5, 3, 3)).distance == Approx(0.5).margin(0.02));
  CHECK(wall->distance(Vec3(4.5, 4.5, 4.5)).distance < 0);
  CHECK(wall->distance(Vec3(6.5, 6.5, 7.5)).distance == Approx(0.5).margin(0.02));
  CHECK_FALSE(wall->violation(blockOf(Vec3(5.1, 1, 1), Vec3(8, 3.9, 3.9))));
  CHECK(wall->violation(blockOf(Vec3(4.2, 4.2, 4.2), Vec3(4.8, 4.8, 4.8))));
  CHECK(wall->violation(blockOf(Vec3(5.1, 1, 1), Vec3(8, 4.1, 4.1))));
  // Of the 12 triangles of c none is seen, of those that cross all.
  CHECK(container->surface().triangles.size() == 12 + 12 + 12);

  const auto bar =
      subtractObstacles(room({true, false, false}), {cubeObstacle(Vec3(-1, 5, 5), Vec3(21, 8, 8))});
  CHECK(bar->volume() == Approx(8000 - 180).margin(0.8));
  CHECK(bar->wall()->violation(blockOf(Vec3(19, 6, 6), Vec3(22, 7, 7))));
  CHECK_FALSE(bar->wall()->violation(blockOf(Vec3(19, 1, 1), Vec3(22, 4.9, 4.9))));
}

TEST_CASE("Obstacles can extend beyond a round wall", "[obstacles]") {
  // The half of a pipe of radius 8 and length 20.
  const auto pipe = std::shared_ptr<const Container>(makeCylinder(Vec3(10, 10, 10), 0, 8, 20, false));
  const auto half = subtractObstacles(pipe, {cubeObstacle(Vec3(-5, -5, -5), Vec3(25, 10, 25))});
  CHECK(half->volume() == Approx(0.5 * pipe->volume()).epsilon(4e-4));
}

TEST_CASE("A ball and a bar that extend beyond the wall form a stenosis", "[obstacles]") {
  const auto pipe = std::shared_ptr<const Container>(makeCylinder(Vec3(10, 10, 10), 0, 8, 20, false));
  const double r = 5.0;
  const auto stenosis = subtractObstacles(pipe, {{makeSphere(Vec3(10, 18, 10), r)->surface(), "ball"},
                                                 cubeObstacle(Vec3(2, 12, 9), Vec3(18, 20, 11))});
  CHECK(stenosis->volume() < pipe->volume() - 16 * 2 * 5);
  CHECK(stenosis->volume() > pipe->volume() - 16 * 2 * 6 - 2.0 / 3.0 * 3.1416 * r * r * r);
  CHECK(stenosis->wall()->violation(blockOf(Vec3(9, 13.5, 9), Vec3(11, 14, 11))));
  CHECK_FALSE(stenosis->wall()->violation(blockOf(Vec3(9, 4, 9), Vec3(11, 11.9, 11))));
  // What lies beyond the round wall, or in another body, is no part of the surface.
  CHECK(stenosis->surface().triangles.size() <
        pipe->surface().triangles.size() + makeSphere(Vec3::Zero(), r)->surface().triangles.size());
}
