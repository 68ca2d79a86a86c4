// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Lumens for tests: every kind of wall the library knows.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "packMesh/container/obstacles.h"
#include "packMesh/container/primitives.h"
#include "packMesh/container/vessel.h"
#include "tests/packMesh/sample_meshes.h"

namespace packmesh::test {

struct NamedContainer {
  std::string name;
  std::shared_ptr<const Container> container;
  const Wall& wall() const { return *container->wall(); }
};

/// A tube along x whose middle line sways and whose radius varies, the same at x = 0 and 30.
inline TriangleMesh swayingTube(int rings = 61, int sides = 24) {
  return sample::tube(
      0.0, 30.0, rings, sides, [](double x) { return Vec3(x, 3.0 * std::sin(2.0 * M_PI * x / 30.0), 0.0); },
      [](double x) { return 6.0 + std::cos(2.0 * M_PI * x / 30.0); });
}

inline const std::vector<NamedContainer>& allContainers() {
  static const std::vector<NamedContainer> containers = [] {
    const Box room{{-1.0, 2.0, 0.0}, {19.0, 20.0, 16.0}};
    const TriangleMesh ball = makeSphere({9.0, 11.0, 8.0}, 3.0)->surface();
    const TriangleMesh post = sample::box({6.0, 8.0, -1.0}, {9.0, 12.0, 17.0});
    std::vector<NamedContainer> all;
    const auto add = [&](const std::string& name, std::shared_ptr<const Container> container) {
      all.push_back({name, std::move(container)});
    };
    add("box", makeBox(room, {false, false, false}));
    add("slit", makeBox(room, {true, true, false}));
    add("cylinder", makeCylinder({5.0, -3.0, 2.0}, 1, 8.0, 30.0, false));
    add("periodic cylinder", makeCylinder({25.0, 0.0, 0.0}, 0, 12.5, 50.0, true));
    add("sphere", makeSphere({1.0, 2.0, 3.0}, 11.0));
    add("far sphere", makeSphere({4e4, -2e4, 1e4}, 11.0));
    add("wide cylinder", makeCylinder({0.0, 5e3, 0.0}, 2, 5e3, 100.0, true));
    add("vessel", makeVessel(sample::sphere({2.0, 1.0, 0.0}, 9.0, 16, 20), std::nullopt, 0.25));
    add("vessel with ends", makeVessel(swayingTube(), VesselEnds{0, -1.0, 31.0, false}, 0.25));
    add("periodic vessel", makeVessel(swayingTube(), VesselEnds{0, 0.0, 30.0, true}, 0.25));
    add("obstacles", subtractObstacles(makeBox(room, {true, false, false}), {{ball, "ball"}}));
    add("posts", subtractObstacles(makeBox(room, {true, true, false}), {{post, "post"}}));
    return all;
  }();
  return containers;
}

}  // namespace packmesh::test
