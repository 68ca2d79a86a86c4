// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/tetrahedra.h"
#include "packMesh/core/error.h"
#include "packMesh/mesh/closest_point.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/predicates.h"
#include "tests/packMesh/cat/cat_scenes.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::test;

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
  const int middle = int(box.vertices.size()) - 1;
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
    for (std::size_t i = 0; i < t.tetrahedra.size(); ++i) sum += volumeOf(t, int(i));
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

using namespace packmesh::test;

namespace {

/// Everything that fits into a container.
std::vector<std::pair<std::string, CatScene>> walledScenes() {
  return {{"four cubes", fourCubes()},
          {"spheres and cubes", spheresAndCubes()},
          {"mixture", mixture()},
          {"red cells", redCellsInSphere(8, 0.45)},
          {"small red cells", redCellsInSphere(8, 0.45, 0.2)},
          {"one red cell", redCellsInSphere(1, 0.2)}};
}

using Face = std::array<int, 3>;

Face faceOf(const Tetrahedron& t, int opposite) {
  Face face{t[(opposite + 1) % 4], t[(opposite + 2) % 4], t[(opposite + 3) % 4]};
  std::sort(face.begin(), face.end());
  return face;
}

double areaOf(const Tetrahedra& t, const Face& f) {
  return 0.5 * (t.points[f[1]] - t.points[f[0]]).cross(t.points[f[2]] - t.points[f[0]]).norm();
}

std::ptrdiff_t steinerPoints(const Tetrahedra& t) {
  return std::count(t.vertices.begin(), t.vertices.end(), -1);
}

}  // namespace

TEST_CASE(
    "Tetrahedra fill the space between objects and container; surfaces are unions of their faces, whose "
    "Steiner points have the label of the surface",
    "[tetrahedra][long]") {
  for (const auto& [name, scene] : walledScenes()) {
    INFO(name);
    const Tetrahedra t = tetrahedralise(scene.input);
    double sum = 0.0;
    for (int n = 0; n < int(t.tetrahedra.size()); ++n) {
      REQUIRE(sideOfPlane(t.corner(n, 0), t.corner(n, 1), t.corner(n, 2), t.corner(n, 3)) == 1);
      sum += volumeOf(t, n);
    }
    CHECK(sum == Approx(scene.containerVolume() - scene.objectVolume()).epsilon(1e-9));
    std::map<Face, int> tetrahedraAt;
    for (const Tetrahedron& corners : t.tetrahedra)
      for (int k = 0; k < 4; ++k) ++tetrahedraAt[faceOf(corners, k)];
    std::map<int, double> area;
    for (const auto& [face, count] : tetrahedraAt) {
      REQUIRE(count <= 2);
      if (count == 2) continue;
      const int label = t.labels[face[0]];
      REQUIRE(t.labels[face[1]] == label);
      REQUIRE(t.labels[face[2]] == label);
      area[label] += areaOf(t, face);
    }
    CHECK(area[wallLabel] == Approx(surfaceArea(scene.input.container->mesh())).epsilon(1e-9));
    for (std::size_t b = 0; b < t.bodies.size(); ++b) {
      const PlacedMesh& object = scene.input.objects[t.bodies[b].object];
      CHECK(area[int(b)] == Approx(surfaceArea(placed(object.mesh->mesh(), object.placement))).epsilon(1e-9));
    }
    for (std::size_t p = 0; p < t.points.size(); ++p) {
      if (t.vertices[p] >= 0) continue;
      const int label = t.labels[p];
      const TriangleMesh surface = label == wallLabel
                                       ? scene.input.container->mesh()
                                       : placed(scene.input.objects[t.bodies[label].object].mesh->mesh(),
                                                scene.input.objects[t.bodies[label].object].placement);
      CHECK(ClosestPoint(surface).nearest(t.points[p]).distance < 1e-9);
    }
  }
  CHECK(steinerPoints(tetrahedralise(redCellsInSphere(8, 0.45).input)) > 0);
}

TEST_CASE("Points are numbered by body and vertex", "[tetrahedra]") {
  const CatScene scene = mixture();
  const Tetrahedra t = tetrahedralise(scene.input);
  REQUIRE(t.bodies.size() == scene.input.objects.size());
  for (std::size_t b = 0; b < t.bodies.size(); ++b) {
    const PlacedMesh& object = scene.input.objects[t.bodies[b].object];
    const std::vector<Vec3>& vertices = object.mesh->mesh().vertices;
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      REQUIRE(t.points[t.bodies[b].firstPoint + v] == object.placement(vertices[v]));
      REQUIRE(t.labels[t.bodies[b].firstPoint + v] == int(b));
      REQUIRE(t.vertices[t.bodies[b].firstPoint + v] == int(v));
    }
  }
  const std::vector<Vec3>& wall = scene.input.container->mesh().vertices;
  std::size_t found = 0;
  for (std::size_t p = 0; p < t.points.size(); ++p)
    if (t.labels[p] == wallLabel && t.vertices[p] >= 0) {
      REQUIRE(t.points[p] == wall[t.vertices[p]]);
      ++found;
    }
  CHECK(found == wall.size());
}

TEST_CASE("Growth uses only the tetrahedra that join surfaces", "[tetrahedra]") {
  CatScene scene = mixture();
  const Tetrahedra all = tetrahedralise(scene.input);
  scene.input.kept = TetrahedraKept::joining;
  const Tetrahedra some = tetrahedralise(scene.input);
  std::vector<Tetrahedron> joining;
  std::copy_if(
      all.tetrahedra.begin(), all.tetrahedra.end(), std::back_inserter(joining), [&](const Tetrahedron& t) {
        return std::any_of(t.begin(), t.end(), [&](int p) { return all.labels[p] != all.labels[t[0]]; });
      });
  CHECK(joining.size() < all.tetrahedra.size());
  const auto sorted = [](std::vector<Tetrahedron> tetrahedra) {
    for (Tetrahedron& t : tetrahedra) std::sort(t.begin(), t.end());
    std::sort(tetrahedra.begin(), tetrahedra.end());
    return tetrahedra;
  };
  CHECK(sorted(joining) == sorted(some.tetrahedra));
}

TEST_CASE("Without a container, only triangles missing from the Delaunay tetrahedra are constrained",
          "[tetrahedra]") {
  int broken = 0;
  for (CatScene scene :
       {mixture(), redCellsInSphere(6, 0.45), coarse(redCellsInPeriodicBox(12.0, 0.35), 1, 0.85)}) {
    scene.input.container = nullptr;
    scene.input.kept = TetrahedraKept::joining;
    // Middles of tetrahedra that are inside of an object.
    const auto inside = [&] {
      const Tetrahedra t = tetrahedralise(scene.input);
      REQUIRE(t.attempts == 1);
      CHECK(t.tetrahedra.size() > 100);
      int count = 0;
      for (const Tetrahedron& corners : t.tetrahedra) {
        Vec3 middle = Vec3::Zero();
        for (const int p : corners) middle += 0.25 * t.points[p];
        for (const TetrahedraBody& body : t.bodies) {
          const PlacedMesh& object = scene.input.objects[body.object];
          Placement placement = object.placement;
          placement.translation += body.shift;
          const Sphere sphere = boundingSphere(*object.mesh, placement);
          if ((middle - sphere.center).norm() < sphere.radius)
            count += isInside(middle, *object.mesh, placement);
        }
      }
      return count;
    };
    CHECK(inside() == 0);
    scene.input.kind = TetrahedraKind::delaunay;
    broken += inside() > 0;
  }
  CHECK(broken > 0);  // not in vain
}

TEST_CASE("Triangles that are not faces of tetrahedra are found", "[tetrahedra]") {
  // Two tetrahedra on either side of triangle 0 1 2.
  const std::vector<Tetrahedron> two = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  const std::vector<Triangle> triangles = {{2, 1, 0}, {3, 4, 0}, {3, 0, 1}, {4, 1, 2}, {1, 3, 4}};
  CHECK(missingTriangles(triangles, two, 5) == std::vector<int>{1, 4});
  CHECK(missingTriangles(triangles, {{0, 1, 2, 3}}, 5) == std::vector<int>{1, 3, 4});
  CHECK(missingTriangles({}, two, 5).empty());
}

TEST_CASE("Tetrahedra do not depend on the order of the objects", "[tetrahedra][long]") {
  for (CatScene scene :
       {mixture(), redCellsInSphere(4, 0.45), coarse(redCellsInPeriodicBox(12.0, 0.3), 1, 0.85)}) {
    const Tetrahedra before = tetrahedralise(scene.input);
    std::vector<int> order(scene.input.objects.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = int(i);
    std::shuffle(order.begin(), order.end(), std::mt19937(3));
    const std::vector<PlacedMesh> objects = scene.input.objects;
    for (std::size_t i = 0; i < order.size(); ++i) scene.input.objects[i] = objects[order[i]];
    const Tetrahedra after = tetrahedralise(scene.input);
    CHECK(before.points == after.points);
    CHECK(before.labels == after.labels);
    CHECK(before.tetrahedra == after.tetrahedra);
    REQUIRE(before.bodies.size() == after.bodies.size());
    for (std::size_t b = 0; b < before.bodies.size(); ++b)
      CHECK(order[after.bodies[b].object] == before.bodies[b].object);
  }
}

TEST_CASE("Tetrahedra with periodic images fill the period", "[tetrahedra][long]") {
  const auto check = [](const CatScene& scene, double volume) {
    const Tetrahedra t = tetrahedralise(scene.input);
    // Each corner is a primary object's in just one of a tetrahedron's images.
    double sum = 0.0;
    for (std::size_t i = 0; i < t.tetrahedra.size(); ++i)
      for (int k = 0; k < 4; ++k)
        if (const int p = t.tetrahedra[i][k]; t.isPrimary(t.labels[p])) sum += 0.25 * volumeOf(t, int(i));
    CHECK(sum == Approx(volume - scene.objectVolume()).epsilon(1e-9));
    CHECK(std::size_t(std::count_if(t.bodies.begin(), t.bodies.end(), [](const TetrahedraBody& b) {
            return b.primary;
          })) == scene.input.objects.size());
  };
  check(coarse(redCellsInPeriodicBox(13.0, 0.35), 1, 0.85), std::pow(13.0, 3));
  check(coarse(redCellsInPeriodicBox(13.0, 0.35), 1, 0.5), std::pow(13.0, 3));
  check(coarse(redCellsInPeriodicBox(9.0, 0.12), 2, 0.9), std::pow(9.0, 3));
}

TEST_CASE("Unconstrained Delaunay tetrahedra have empty circumspheres", "[tetrahedra]") {
  CatScene scene = spheresAndCubes();
  scene.input.kind = TetrahedraKind::delaunay;
  const Tetrahedra t = tetrahedralise(scene.input);
  CHECK(steinerPoints(t) == 0);
  CHECK(t.tetrahedra.size() > 1000);
  for (std::size_t i = 0; i < t.tetrahedra.size(); i += 7) {
    const int n = int(i);
    Mat3 edges;
    Vec3 rhs;
    for (int k = 0; k < 3; ++k) {
      edges.col(k) = t.corner(n, k + 1) - t.corner(n, 0);
      rhs[k] = 0.5 * edges.col(k).squaredNorm();
    }
    const Vec3 offset = edges.inverse().transpose() * rhs, center = t.corner(n, 0) + offset;
    if (!(offset.norm() < 1e3)) continue;  // flat: the sphere is a plane
    for (const Vec3& p : t.points) CHECK((p - center).norm() > offset.norm() * (1.0 - 1e-7));
  }
}

TEST_CASE("With fewer points on surfaces, the tetrahedra of the remaining points are kept", "[tetrahedra]") {
  CatScene scene = redCellsInSphere(8, 0.3);
  scene.input.container = nullptr;
  scene.input.kind = TetrahedraKind::delaunay;
  scene.input.kept = TetrahedraKept::joining;
  const Tetrahedra all = tetrahedralise(scene.input);
  for (const PlacedMesh& object : scene.input.objects) {
    scene.input.bodies.push_back({int(scene.input.bodies.size()), Vec3::Zero(), true});
    scene.input.points.emplace_back();
    int v = 0;
    for (const Vec3& vertex : object.mesh->mesh().vertices)
      scene.input.points.back().push_back(vertex.x() > 0.0 || v++ % 8 == 0);
  }
  const Tetrahedra some = tetrahedralise(scene.input);
  CHECK(2 * some.points.size() < 3 * all.points.size() / 2);
  // By body and vertex, which number the same points in both.
  using Corner = std::pair<int, int>;
  const auto cornersOf = [](const Tetrahedra& t, const Tetrahedron& tetrahedron) {
    std::array<Corner, 4> corners;
    for (int k = 0; k < 4; ++k)
      corners[k] = {t.bodies[t.labels[tetrahedron[k]]].object, t.vertices[tetrahedron[k]]};
    std::sort(corners.begin(), corners.end());
    return corners;
  };
  std::set<std::array<Corner, 4>> found;
  for (const Tetrahedron& t : some.tetrahedra) found.insert(cornersOf(some, t));
  std::int64_t expected = 0;
  for (const Tetrahedron& t : all.tetrahedra) {
    const std::array<Corner, 4> corners = cornersOf(all, t);
    if (!std::all_of(corners.begin(), corners.end(),
                     [&](const Corner& c) { return scene.input.points[c.first][c.second]; }))
      continue;
    ++expected;
    CHECK(found.count(corners) == 1);
  }
  CHECK(expected > 100);
}

TEST_CASE("A tetrahedralisation can be stopped", "[tetrahedra]") {
  CatScene scene = redCellsInSphere(8, 0.45);
  TetrahedraInput& input = scene.input;
  int polls = 0;
  input.stop = [&] { return ++polls > 1; };
  REQUIRE_THROWS_WITH(tetrahedralise(input), Contains("it was stopped"));
  REQUIRE(polls == 2);
}
