// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/mesh_repair.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/support/catch.h"

using namespace packmesh;

TEST_CASE("A mesh without coincident triangles stays as it is", "[geometry]") {
  TriangleMesh mesh = sample::torus(Vec3::Zero(), 3.0, 1.0, 30, 20);
  const std::vector<Triangle> before = mesh.triangles;
  CHECK(removeCoincident(mesh) == 0);
  CHECK(mesh.triangles == before);
}

TEST_CASE("Triangles that occur twice count once, and a fin is removed", "[geometry]") {
  const TriangleMesh sound = sample::box(-Vec3::Ones(), Vec3::Ones());
  TriangleMesh mesh = sound;
  SECTION("twice, also from another corner") {
    const Triangle t = sound.triangles[3];
    mesh.triangles.push_back(t);
    mesh.triangles.push_back({t[1], t[2], t[0]});
    CHECK(removeCoincident(mesh) == 2);
  }
  SECTION("a fin") {
    mesh.vertices.emplace_back(0.0, 0.0, 3.0);
    const int tip = int(mesh.vertices.size()) - 1;
    mesh.triangles.push_back({4, 7, tip});
    mesh.triangles.push_back({7, 4, tip});
    CHECK(removeCoincident(mesh) == 2);
  }
  SECTION("a cap of which the second has the opposite orientation") {
    for (const int t : {0, 1})
      mesh.triangles.push_back({sound.triangles[t][0], sound.triangles[t][2], sound.triangles[t][1]});
    CHECK(removeCoincident(mesh) == 2);
  }
  SECTION("all of the surface is there twice") {
    mesh.triangles.insert(mesh.triangles.end(), sound.triangles.begin(), sound.triangles.end());
    CHECK(removeCoincident(mesh) == 12);
  }
  repairClosed(mesh, "x");
  CHECK(mesh.triangles.size() == 12);
  CHECK(signedVolume(mesh) == Approx(8.0));
}

TEST_CASE("Vertices that rounding has put apart where the surface pinches itself are merged", "[geometry]") {
  // A wall of a box with a vertex, of which the two sides are a hair apart, so that three edges have four
  // triangles each.
  TriangleMesh mesh = sample::box(-Vec3::Ones(), Vec3::Ones());
  const Triangle cut = mesh.triangles[3];
  mesh.triangles.erase(mesh.triangles.begin() + 3);
  const Vec3 middle = (mesh.vertices[cut[0]] + mesh.vertices[cut[1]] + mesh.vertices[cut[2]]) / 3.0;
  const int a = int(mesh.vertices.size());
  mesh.vertices.push_back(middle);
  mesh.vertices.push_back(middle + Vec3(1e-7, 0, 0));
  for (int k = 0; k < 3; ++k) mesh.triangles.push_back({cut[k], cut[(k + 1) % 3], a});
  mesh.triangles.push_back({cut[0], a, a + 1});  // a fin of no width
  mesh.triangles.push_back({cut[0], a + 1, a});
  mesh.triangles.push_back({cut[1], a, a + 1});
  mesh.triangles.push_back({cut[1], a + 1, a});
  repairClosed(mesh, "x");
  CHECK(signedVolume(mesh) == Approx(8.0));
  CHECK(mesh.triangles.size() == 14);
}
