// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/cat_face_planes.h"

#include "packMesh/cat/cat_cells.h"
#include "packMesh/cat/tetrahedra.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "tests/packMesh/cat/cat_scenes.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::test;

namespace {

struct Built {
  Tetrahedra tetrahedra;
  ChordalFaces split;

  explicit Built(CatScene scene, TetrahedraKept kept = TetrahedraKept::joining) {
    scene.input.kept = kept;
    tetrahedra = tetrahedralise(scene.input);
    splitChordally(tetrahedra, WallFaces::atWall, split);
  }
};

std::size_t planesIn(const PlaneConstraints& planes) {
  std::size_t count = 0;
  for (const auto& of : planes) count += of.size();
  return count;
}

/// How far the vertex of a constraint is beyond its plane [µm].
double beyond(const PlaneConstraint& plane, const Placement& placement) {
  return plane.normal.dot(placement(plane.vertex) - plane.point);
}

}  // namespace

TEST_CASE("Every vertex is behind the planes of its CAT faces", "[cat]") {
  for (const CatScene& scene : {fourCubes(), spheresAndCubes(), mixture(), redCellsInSphere(6, 0.45),
                                coarse(redCellsInPeriodicBox(12.0, 0.3), 1, 0.85)}) {
    const Built built(scene);
    const PlaneConstraints planes = planesOfFaces(built.tetrahedra, built.split, scene.input.objects, 0.0);
    REQUIRE(planes.size() == scene.input.objects.size());
    for (std::size_t i = 0; i < planes.size(); ++i) {
      CHECK(planes[i].size() > 8);
      for (const PlaneConstraint& plane : planes[i]) {
        CHECK(plane.normal.norm() == Approx(1.0));
        CHECK(beyond(plane, scene.input.objects[i].placement) < 1e-12);
      }
    }
  }
}

TEST_CASE("Objects that stay behind the planes of their CAT faces do not meet", "[cat]") {
  // Grown in place until the first of its vertices reaches a plane, each object stays in its own cell.
  for (const CatScene& scene : {spheresAndCubes(), redCellsInSphere(6, 0.3, 0.4)}) {
    const Built built(scene, TetrahedraKept::freeSpace);
    const PlaneConstraints planes = planesOfFaces(built.tetrahedra, built.split, scene.input.objects, 0.0);
    const CatCells cells = catCells(built.tetrahedra, WallFaces::atWall);
    for (std::size_t i = 0; i < planes.size(); ++i) {
      const PlacedMesh& object = scene.input.objects[i];
      double scale = 10.0;
      for (const PlaneConstraint& plane : planes[i]) {
        const double arm = plane.normal.dot(object.placement.linear * plane.vertex);
        const double room = plane.normal.dot(plane.point - object.placement.translation);
        if (arm > 0.0) scale = std::min(scale, room / arm);
      }
      CHECK(scale > 1.0);
      Placement grown = object.placement;
      grown.linear *= 1.0 + 0.999 * (scale - 1.0);
      const MeshHierarchy cell(cells.cells[i]);
      CHECK(relate(*object.mesh, grown, cell, Placement()).relation == MeshRelation::firstInside);
      grown.linear = 10.0 * object.placement.linear;
      CHECK(relate(*object.mesh, grown, cell, Placement()).relation != MeshRelation::firstInside);
    }
  }
}

TEST_CASE("A CAT face belongs to the objects on both sides, and only faces of the container have one side",
          "[cat]") {
  const CatScene scene = redCellsInSphere(6, 0.45);
  const Built built(scene);
  const PlaneConstraints planes = planesOfFaces(built.tetrahedra, built.split, scene.input.objects, 0.0);
  const auto keyOf = [](const Vec3& point, const Vec3& normal) {
    return std::array<double, 6>{point.x(), point.y(), point.z(), normal.x(), normal.y(), normal.z()};
  };
  std::set<std::array<double, 6>> known;
  for (const auto& of : planes)
    for (const PlaneConstraint& plane : of) known.insert(keyOf(plane.point, plane.normal));
  for (const ChordalFace& face : built.split.faces) {
    const auto labelOf = [&](int side) {
      for (int k = 0; k < 4; ++k)
        if (side >> k & 1) return built.tetrahedra.labels[built.tetrahedra.tetrahedra[face.tetrahedron][k]];
      return wallLabel;
    };
    if (labelOf(face.first) != wallLabel) CHECK(known.count(keyOf(face.point, face.normal)) == 1);
    if (labelOf(face.second) != wallLabel) CHECK(known.count(keyOf(face.point, -face.normal)) == 1);
  }
}

TEST_CASE("Faces of slivers are omitted", "[cat]") {
  // Two edges that cross at a small distance, and a tetrahedron with an ordinary gap.
  Tetrahedra t;
  t.points = {{-1, 0, 0}, {1, 0.0, 0}, {0, -1, 0.01}, {0, 1, 0.01},
              {0, 0, 5},  {1, 0, 5},   {0, 1, 5},     {0, 0, 6}};
  t.labels = {0, 1, 0, 1, 0, 0, 0, 1};
  t.vertices = {0, 0, 1, 1, 2, 3, 4, 2};
  t.tetrahedra = {{0, 1, 2, 3}, {4, 5, 6, 7}};
  t.bodies = {{0, Vec3::Zero(), true, 0}, {1, Vec3::Zero(), true, 0}};
  for (Tetrahedron& corners : t.tetrahedra) {
    const auto at = [&](int k) { return t.points[corners[k]]; };
    if ((at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0)) < 0.0) std::swap(corners[0], corners[1]);
  }
  ChordalFaces split;
  splitChordally(t, WallFaces::midGap, split);
  REQUIRE(split.faces.size() == 2);
  const MeshHierarchy anyMesh(sample::box(Vec3::Constant(-1.0), Vec3::Constant(1.0)));
  const std::vector<PlacedMesh> objects(2, {&anyMesh, Placement()});
  CHECK(planesIn(planesOfFaces(t, split, objects, 0.0)) == 8);
  CHECK(planesIn(planesOfFaces(t, split, objects, 0.3)) == 8);  // edges cross the gap straight on
  // The same four points, but now the two sides are on edges that nearly meet: the normal is across both.
  t.labels = {0, 0, 1, 1, 0, 0, 0, 1};
  splitChordally(t, WallFaces::midGap, split);
  CHECK(planesIn(planesOfFaces(t, split, objects, 0.0)) == 8);
  CHECK(planesIn(planesOfFaces(t, split, objects, 0.3)) == 4);
}

TEST_CASE("Only planes further away than a cell can move are omitted", "[cat]") {
  const CatScene scene = redCellsInSphere(6, 0.45);
  const Built built(scene);
  const std::vector<double> reach = {0.3, 0.0, 0.6, 0.3, 1.0, 0.3};
  const PlaneConstraints all = planesOfFaces(built.tetrahedra, built.split, scene.input.objects, 0.3);
  const PlaneConstraints near = planesOfFaces(built.tetrahedra, built.split, scene.input.objects, 0.3, reach);
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::vector<PlaneConstraint> expected;
    for (const PlaneConstraint& plane : all[i])
      if (-beyond(plane, scene.input.objects[i].placement) <= reach[i]) expected.push_back(plane);
    CHECK(expected.size() < all[i].size());
    CHECK(near[i].size() == Approx(expected.size()).margin(1));  // rounding
    CHECK(near[i].empty() == (reach[i] == 0.0));
  }
}
