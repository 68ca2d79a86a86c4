// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/shape/shape.h"

#include <catch2/catch.hpp>

#include "packMesh/shape/surface_distance.h"
#include "tests/support/shapes.h"

using namespace packmesh;

TEST_CASE("A template of another size has the volume, the extents and the distances of that size") {
  constexpr double factor = 0.6;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int examined = 0;
  for (const auto& [name, shape] : test::allShapes()) {
    if (shape->undeformed()) continue;
    CAPTURE(name);
    ++examined;
    const Shape small(*shape, factor);
    CHECK(small.volume() == Approx(factor * factor * factor * shape->volume()));
    CHECK(small.radius() == Approx(factor * shape->radius()));
    CHECK(small.halfThickness() == Approx(factor * shape->halfThickness()));
    CHECK(small.bound().semiAxes.maxCoeff() == Approx(factor * shape->bound().semiAxes.maxCoeff()));
    CHECK(small.mesh().triangles == shape->mesh().triangles);
    const SurfaceDistance distance(*shape), ofSmall(small);
    for (int n = 0; n < 300; ++n) {
      const Vec3 p = 1.2 * shape->radius() * unit(random) * test::randomDirection(random);
      CHECK(ofSmall.sample(factor * p).distance ==
            Approx(factor * distance.sample(p).distance).margin(1e-5 * shape->radius()));
    }
  }
  CHECK(examined >= 3);
}
