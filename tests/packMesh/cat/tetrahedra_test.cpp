// SPDX-License-Identifier: AGPL-3.0-or-later
#include <catch2/catch.hpp>

#include "packMesh/cat/tetrahedra.h"
#include "packMesh/cat/tetrahedralise.h"
#include "packMesh/core/error.h"
#include "tests/packMesh/cat/cat_scenes.h"

using namespace packmesh;
using namespace packmesh::test;
using Catch::Contains;
using Catch::EndsWith;

namespace {

/// Three small cubes in a large one; tests spoil one of them.
CatScene threeCubes() {
  CatScene scene;
  scene.input.container = scene.own(sample::box(Vec3::Zero(), Vec3::Constant(10.0)));
  const MeshHierarchy* cube = scene.own(sample::box(Vec3::Constant(-1.0), Vec3::Constant(1.0)));
  for (const Vec3& at : {Vec3(2, 2, 2), Vec3(7, 7, 7), Vec3(2, 7, 2)})
    scene.input.objects.push_back({cube, {Mat3::Identity(), at}});
  return scene;
}

}  // namespace

TEST_CASE("Objects that meet or are misplaced are named", "[tetrahedra]") {
  CatScene scene = threeCubes();
  CHECK_NOTHROW(requireValid(scene.input));
  Placement& second = scene.input.objects[1].placement;

  second.translation = {3.9, 2.5, 2.1};
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("object 0 and object 1 meet"));
  scene.input.names = {"RBC 1", "RBC 2", "PLT 1"};
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("RBC 1 and RBC 2 meet"));
  second.translation = {4.0, 2.0, 2.0};  // they share a face
  CHECK_THROWS_AS(tetrahedralise(scene.input), InputError);
  second = {0.3 * Mat3::Identity(), {2.0, 7.1, 2.0}};
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("RBC 2 is inside PLT 1"));
  second = {Mat3::Identity(), {9.5, 7.0, 7.0}};
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("RBC 2 meets the container's wall"));
  second.translation = {19.5, 7.0, 7.0};
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("RBC 2 is outside the container"));
  second.translation = {std::nan(""), 7.0, 7.0};
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("RBC 2 has a placement"));
  second.translation = {1e200, 7.0, 7.0};
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("RBC 2 is more than"));
  second = {-Mat3::Identity(), {7.0, 7.0, 7.0}};
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("RBC 2 has a placement"));
  scene.input.objects.clear();
  CHECK_THROWS_AS(tetrahedralise(scene.input), InputError);
}

TEST_CASE("Objects that meet periodic images are named", "[tetrahedra]") {
  CatScene scene = threeCubes();
  scene.input.container = nullptr;
  scene.input.bounds = {Vec3::Zero(), Vec3::Constant(10.0)};
  scene.input.period = Vec3::Constant(10.0);
  CHECK_NOTHROW(requireValid(scene.input));
  scene.input.objects[1].placement.translation = {9.5, 7.5, 1.5};
  CHECK_NOTHROW(requireValid(scene.input));
  scene.input.objects[1].placement.translation = {10.5, 7.5, 1.5};
  CHECK_THROWS_WITH(tetrahedralise(scene.input),
                    Contains("object 1 and object 2, as an image moved by (10, 0, 0)"));
  scene.input.objects[1].placement = {5.5 * Mat3::Identity(), {5.0, 5.0, 5.0}};
  scene.input.objects.erase(scene.input.objects.begin());
  scene.input.objects.pop_back();
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("object 0 and object 0, as an image"));
}

TEST_CASE("Meshes that do not bound a body are rejected by name", "[tetrahedra]") {
  CatScene scene = threeCubes();
  scene.input.names = {"good", "bad", "good too"};
  const auto refuse = [&](const TriangleMesh& mesh, const std::string& why) {
    INFO(why);
    scene.input.objects[1].mesh = scene.own(mesh);
    CHECK_THROWS_AS(tetrahedralise(scene.input), MeshError);
    CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("bad") && Contains(why));
  };
  const TriangleMesh cube = sample::box(Vec3::Constant(-1.0), Vec3::Constant(1.0));

  TriangleMesh open = cube;
  open.triangles.pop_back();
  refuse(open, "not closed");

  TriangleMesh crossing = icosphere(2);
  crossing.vertices[0] *= -3.0;
  refuse(crossing, "intersects itself");

  TriangleMesh flat = cube;
  for (Vec3& v : flat.vertices) v.z() = 0.0;
  refuse(flat, "bad");

  // Two sheets in one place.
  TriangleMesh thin = cube;
  for (Vec3& v : thin.vertices) v.z() *= 1e-17;
  for (Vec3& v : thin.vertices) v.z() += 1.0;
  refuse(thin, "bad");

  TriangleMesh insideOut = cube;
  flip(insideOut);
  refuse(insideOut, "inside out");

  TriangleMesh pinched = cube;
  sample::append(pinched, sample::box(Vec3::Constant(1.0), Vec3::Constant(2.0)));
  refuse(pinched, "bad");

  scene = threeCubes();
  open = scene.input.container->mesh();
  open.triangles.pop_back();
  scene.input.container = scene.own(open);
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("the container") && Contains("not closed"));
}

TEST_CASE("A container with different ends cannot be continued periodically", "[tetrahedra]") {
  CatScene scene = threeCubes();
  scene.input.bounds = {Vec3::Zero(), Vec3::Constant(10.0)};
  scene.input.period = {10.0, 0.0, 0.0};
  CHECK_NOTHROW(tetrahedralise(scene.input));

  TriangleMesh box = scene.input.container->mesh();
  box.vertices.push_back({10.0, 5.0, 0.0});  // in the middle of an edge of one end
  const TriangleMesh whole = box;
  const int middle = static_cast<int>(box.vertices.size()) - 1;
  box.triangles.clear();
  for (const Triangle& t : whole.triangles) {
    bool cut = false;
    for (int k = 0; k < 3; ++k)
      if ((t[k] == 1 && t[(k + 1) % 3] == 3) || (t[k] == 3 && t[(k + 1) % 3] == 1)) {
        cut = true;
        box.triangles.push_back({t[k], middle, t[(k + 2) % 3]});
        box.triangles.push_back({middle, t[(k + 1) % 3], t[(k + 2) % 3]});
      }
    if (!cut) box.triangles.push_back(t);
  }
  scene.input.container = scene.own(box);
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("along x") && Contains("must match"));

  scene.input.container = scene.own(icosphere(2, 40.0));
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("along x") && Contains("not flat"));
}

TEST_CASE("TetGen is retried with other settings before it counts as failed", "[tetrahedra]") {
  CatScene scene = redCellsInSphere(4, 0.45);
  const Tetrahedra first = tetrahedralise(scene.input);
  CHECK(first.attempts == 1);
  for (int failing = 1; failing < tetgenVariants; ++failing) {
    scene.input.failingAttempts = failing;
    const Tetrahedra t = tetrahedralise(scene.input);
    CHECK(t.attempts == failing + 1);
    double sum = 0.0;
    for (std::size_t i = 0; i < t.tetrahedra.size(); ++i) sum += volumeOf(t, static_cast<int>(i));
    CHECK(sum == Approx(scene.containerVolume() - scene.objectVolume()).epsilon(1e-9));
    // Points within the volume have labels, too.
    for (const int label : t.labels) CHECK(label >= wallLabel);
    for (const int label : t.labels) CHECK(label < 4);
  }
  scene.input.failingAttempts = tetgenVariants;
  CHECK_THROWS_AS(tetrahedralise(scene.input), TetrahedraError);
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("4 objects") && Contains("3 attempts"));
}

TEST_CASE("An error in TetGen is an exception, and the next run works", "[tetrahedra]") {
  CatScene scene = threeCubes();
  const Placement good = scene.input.objects[1].placement;
  scene.input.objects[1].placement.translation = {3.5, 2.5, 2.1};
  scene.input.valid = true;  // a lie
  scene.input.names = {"A", "B", "C"};
  CHECK_THROWS_AS(tetrahedralise(scene.input), TetrahedraError);
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("3 objects (32 vertices)") &&
                                                     Contains("it found surfaces that intersect (") &&
                                                     EndsWith("): those of A, B"));
  scene.input.explain = false;
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("intersect") && !Contains("those of"));
  scene.input.objects[1].placement = good;
  CHECK_NOTHROW(tetrahedralise(scene.input));
}

TEST_CASE("A failed assertion in TetGen ends its own process only", "[tetrahedra]") {
  // Cubes around one point, of which TetGen 1.5 asserts something that does not hold.
  const auto cube = [](double half, bool insideOut) {
    TriangleMesh mesh;
    for (int k = 0; k < 8; ++k)
      mesh.vertices.emplace_back(k & 1 ? half : -half, k & 2 ? half : -half, k & 4 ? half : -half);
    mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    if (insideOut)
      for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
  };
  CatScene scene;
  TriangleMesh hollow = cube(1.0, false);
  sample::append(hollow, cube(0.5, true));
  scene.input.container = scene.own(cube(10.0, false));
  scene.input.objects = {{scene.own(hollow), Placement()}, {scene.own(cube(0.2, false)), Placement()}};
  CHECK_THROWS_AS(tetrahedralise(scene.input), TetrahedraError);
  CHECK_THROWS_WITH(tetrahedralise(scene.input), Contains("3 attempts: its program has not answered") &&
                                                     Contains("ended by signal 6") && Contains("Assertion"));
  scene.input.objects[1].placement.translation = {0.1, 0.05, 0.0};
  CHECK_NOTHROW(tetrahedralise(scene.input));
}
