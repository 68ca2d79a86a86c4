// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/closest_point.h"
#include "packMesh/mesh/mesh_repair.h"
#include "tests/packMesh/mesh/test_meshes.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/packMesh/simd/triangle_candidates.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

struct Named {
  std::string name;
  TriangleMesh mesh;
};

/// Coarse and fine, long triangles and short ones, sharp edges, hollows, several parts.
std::vector<Named> meshes() {
  TriangleMesh hollow = sample::sphere({0, 0, 0}, 5.0, 12, 16);
  sample::append(hollow, sample::sphere({1, 0, 0}, 2.0, 8, 10));
  repairClosed(hollow, "hollow");
  std::vector<Named> all = {
      {"box", sample::box({-2, -1, -3}, {2, 1.5, 3})},
      {"tube of long triangles", sample::straightTube(-20.0, 20.0, 4.0, 2, 60)},
      {"fine sphere", test::icosphere(5)},
      {"torus", sample::torus({0.5, 0, 0}, 3.0, 1.0, 30, 16)},
      {"hollow", hollow},
      {"steps", sample::voxels(6, 1.0, [](int i, int j, int k) { return i + j + k < 6; })},
  };
  for (Vec3& v : all[2].mesh.vertices) v *= 4.0;
  return all;
}

std::array<std::vector<double>, 3> randomBlock(const Box& box, double spacing, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::array<std::vector<double>, 3> at;
  for (int k = 0; k < 3; ++k) {
    const double first = box.lo[k] + unit(random) * box.size()[k];
    const int count = 1 + int(random() % 12);
    for (int i = 0; i < count; ++i) at[k].push_back(first + spacing * i);
  }
  return at;
}

}  // namespace

TEST_CASE("Distances of blocks equal those of their points", "[geometry]") {
  std::mt19937 random(1);
  for (const Named& named : meshes()) {
    CAPTURE(named.name);
    const SignedDistances distances(named.mesh);
    const Box box = boundingBox(named.mesh).grownBy(2.0);
    int inside = 0, outside = 0, rough = 0;
    for (int n = 0; n < 60; ++n) {
      const double spacing = n % 3 == 0 ? 0.05 : n % 3 == 1 ? 0.3 : 1.0;
      std::array<std::vector<double>, 3> at = randomBlock(box, spacing, random);
      if (n % 7 == 0) at[n % 3].push_back(at[n % 3].back());  // twice the same plane
      const std::size_t count = at[0].size() * at[1].size() * at[2].size();
      std::vector<float> exact(count), bound(count);
      distances.sample(at, false, exact.data());
      distances.sample(at, true, bound.data());
      std::size_t index = 0;
      for (const double z : at[2])
        for (const double y : at[1])
          for (const double x : at[0]) {
            const double expected = distances.surface().signedDistance({x, y, z});
            CAPTURE(x, y, z, spacing);
            REQUIRE(exact[index] == Approx(expected).margin(5e-5));
            if (bound[index] != exact[index]) {
              ++rough;
              REQUIRE((bound[index] < 0.0) == (expected < 0.0));
              REQUIRE(std::abs(bound[index]) <= std::abs(expected) + 5e-5);
              REQUIRE(std::abs(bound[index]) >=
                      (expected < 0.0 ? 0.6 : 1.0 / 1.01) * std::abs(expected) - 5e-5);
            }
            ++(expected < 0.0 ? inside : outside);
            ++index;
          }
    }
    REQUIRE(inside > 500);
    REQUIRE(outside > 500);
    if (named.name != "torus" && named.name != "steps") REQUIRE(rough > 0);
  }
}

TEST_CASE("The nearest triangle is the one with the smallest of all distances", "[geometry][kernel]") {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> coordinate(-3.0f, 3.0f);
  std::vector<TriangleFacts> facts(20);
  for (int t = 0; t < 20; ++t) {
    Vec3 corner[3];
    for (Vec3& c : corner) c = Vec3(coordinate(random), coordinate(random), coordinate(random));
    if (t == 7) corner[2] = corner[1];  // no area
    if (t == 8) corner[1] = corner[2] = corner[0];
    const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
    for (int e = 0; e < 3; ++e) {
      const Vec3 edge = corner[(e + 1) % 3] - corner[e], inward = normal.cross(edge);
      for (int k = 0; k < 3; ++k) {
        facts[t].corner[e][k] = float(corner[e][k]);
        facts[t].edge[e][k] = float(edge[k]);
        facts[t].inward[e][k] = float(inward[k]);
      }
      facts[t].perSquare[e] = edge.squaredNorm() > 0.0 ? float(1.0 / edge.squaredNorm()) : 0.0f;
      facts[t].normal[e] = float(normal[e]);
    }
  }
  TriangleCandidates all(facts);
  std::vector<TriangleCandidates> each;
  for (const TriangleFacts& t : facts) each.emplace_back(std::vector{t});
  for (int n = 0; n < 200; ++n) {
    PointLanes points;
    for (int k = 0; k < 16; ++k) {
      points.x[k] = coordinate(random);
      points.y[k] = coordinate(random);
      points.z[k] = coordinate(random);
    }
    float squared[16], nearest[16];
    all.nearest(triangleKernels(chosenInstructionSet()), points, squared, nearest);
    for (int t = 0; t < 20; ++t) {
      float alone[16], first[16];
      each[t].nearest(triangleKernels(chosenInstructionSet()), points, alone, first);
      for (int k = 0; k < 16; ++k) {
        REQUIRE(squared[k] <= alone[k]);
        if (t == int(nearest[k])) REQUIRE(squared[k] == alone[k]);
      }
    }
  }
}
