// SPDX-License-Identifier: AGPL-3.0-or-later
// Depths below the side wall, and the shells of a lumen.

#include "packMesh/container/side_wall.h"
#include "packMesh/container/obstacles.h"
#include "packMesh/container/primitives.h"
#include "packMesh/container/vessel.h"
#include "packMesh/core/random.h"
#include "tests/support/catch.h"
#include "tests/support/walls.h"

using namespace packmesh;

namespace {

constexpr double tubeLength = 30.0, tubeRadius = 8.0;
constexpr std::array<bool, 3> alongX = {true, false, false}, none = {};

std::vector<std::shared_ptr<const Container>> pipes(bool periodic) {
  return {makeCylinder({0.5 * tubeLength, 0.0, 0.0}, 0, tubeRadius, tubeLength, periodic),
          makeVessel(sample::straightTube(0.0, tubeLength, tubeRadius, 11, 200),
                     VesselEnds{0, 0.0, tubeLength, periodic}, 0.25)};
}

double depthInPipe(const Vec3& p) {
  return tubeRadius - std::hypot(p.y(), p.z());
}

/// A random point in a box around the lumen, which may be outside of it.
Vec3 pointNear(std::uint64_t n) {
  const auto u = uniform4(7, RandomStream::sample, n, 0);
  return {-2.0 + (tubeLength + 4.0) * u[0], 2.2 * tubeRadius * (u[1] - 0.5), 2.2 * tubeRadius * (u[2] - 0.5)};
}

}  // namespace

TEST_CASE("The side wall of a pipe has no ends, whether they are closed or periodic", "[profile]") {
  for (const bool periodic : {false, true})
    for (const auto& pipe : pipes(periodic)) {
      CAPTURE(periodic, pipe->describe());
      const auto wall = std::make_shared<const SideWall>(pipe, alongX);
      CHECK(wall->exists());
      const SideDepth depth(wall, pipe->bounds());
      for (std::uint64_t n = 0; n < 300; ++n) {
        const Vec3 p = pointNear(n);
        const double true_ = depthInPipe(p);
        if (std::abs(true_) > 5.0) continue;
        CHECK(wall->distance(p).distance == Approx(true_).margin(5e-3));
        // Interpolation between nodes 1 µm apart: a second difference of 1/r of an eighth at most.
        if (true_ < 5.0) CHECK(depth(p).distance == Approx(true_).margin(0.09));
      }
    }
}

TEST_CASE("Walls along axes that are no ends stay, also those of obstacles", "[profile]") {
  const auto box =
      std::shared_ptr<const Container>(makeBox({Vec3(0, 0, 0), Vec3(20, 20, 20)}, {false, false, false}));
  const SideWall slit(box, {true, true, false});
  CHECK(slit.distance(Vec3(1, 2, 5)).distance == Approx(5.0));
  CHECK(slit.distance(Vec3(1, 2, 18)).distance == Approx(2.0));
  CHECK_FALSE(SideWall(box, {true, true, true}).exists());
  const auto ball = makeSphere(Vec3(10, 10, 10), 3.0);
  const auto blocked = subtractObstacles(box, {{ball->surface(), "ball"}});
  const SideWall around(blocked, {true, true, false});
  CHECK(around.exists());
  CHECK(around.distance(Vec3(1, 10, 10)).distance == Approx(6.0).margin(0.05));
  CHECK(around.distance(Vec3(1, 2, 3)).distance == Approx(3.0).margin(0.01));
}

TEST_CASE("Shells divide a lumen: a point is in one of them, and gradients lead into it", "[profile]") {
  for (const auto& pipe : pipes(false)) {
    const auto depth =
        std::make_shared<const SideDepth>(std::make_shared<const SideWall>(pipe, alongX), pipe->bounds());
    const double endless = std::numeric_limits<double>::infinity();
    const DepthShell outer(depth, -endless, 2.0), middle(depth, 2.0, 5.0), inner(depth, 5.0, endless);
    int counts[3] = {};
    for (std::uint64_t n = 0; n < 1000; ++n) {
      const Vec3 p = pointNear(n);
      const bool in[] = {outer.contains(p), middle.contains(p), inner.contains(p)};
      CHECK(in[0] + in[1] + in[2] == 1);
      for (int k = 0; k < 3; ++k) counts[k] += in[k];
      const WallDistance away = middle.distance(p);
      if (std::abs(away.distance) > 1.0 || away.distance > -0.01) continue;
      const Vec3 moved = p - 1.05 * away.distance * away.gradient.normalized();
      CHECK(middle.distance(moved).distance > away.distance);
    }
    for (const int count : counts) CHECK(count > 50);
  }
}
