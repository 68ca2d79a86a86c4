// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/field/rough_distance.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "packMesh/mesh/closest_point.h"
#include "tests/support/deformed.h"
#include "tests/support/shapes.h"

using namespace packmesh;

namespace {

/// Compares all nodes with the distances of a search.
void compare(const TriangleMesh& mesh, double spacing) {
  const DistanceGrid grid = sampleRoughly(mesh, boundingBox(mesh).grownBy(spacing), spacing);
  const ClosestPoint surface(mesh);
  std::size_t node = 0;
  for (int k = 0; k < grid.nodes[2]; ++k)
    for (int j = 0; j < grid.nodes[1]; ++j)
      for (int i = 0; i < grid.nodes[0]; ++i, ++node) {
        const double expected = surface.signedDistance(grid.origin + spacing * Vec3(i, j, k)),
                     found = grid.value[node];
        if (std::abs(expected) > 1e-5) REQUIRE((found < 0.0) == (expected < 0.0));
        REQUIRE(std::abs(found) >= std::abs(expected) - 1e-5);
        const double distance = std::abs(expected) / spacing;
        const double error = distance <= 1.0 ? 0.0 : distance < 1.5 ? 0.25 : 0.75;
        REQUIRE(std::abs(found) <= std::abs(expected) + 1e-5 + error * spacing);
      }
}

}  // namespace

TEST_CASE("A rough grid is exact next to the surface, and nearly so elsewhere", "[field]") {
  const std::shared_ptr<const Shape> red = test::redCellShape();
  for (const int seed : {1, 2, 3, 4}) {
    const TriangleMesh mesh{test::deformed(red->mesh(), seed), red->mesh().triangles};
    compare(mesh, 0.33);
    compare(mesh, 0.7);
  }
  compare(red->mesh(), 0.33);
}

TEST_CASE("Rows of a rough grid may meet vertices and edges", "[field]") {
  TriangleMesh octahedron;
  for (int axis = 0; axis < 3; ++axis)
    for (const double x : {1.0, -1.0}) octahedron.vertices.push_back(x * Vec3::Unit(axis));
  octahedron.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                          {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  compare(octahedron, 0.25);
  compare(octahedron, 0.5);
}
