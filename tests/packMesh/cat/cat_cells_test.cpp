// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/cat_cells.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "packMesh/cat/tetrahedralise.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/mesh_repair.h"
#include "packMesh/mesh/touching_parts.h"
#include "tests/packMesh/cat/cat_scenes.h"

using namespace packmesh;
using namespace packmesh::test;

namespace {

/// Nothing, or why the mesh is no closed two-manifold surface, judged by vertex numbers alone.
std::string faultOf(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return "it is empty";
  std::map<std::pair<int, int>, int> third;  // of the triangle to the left of a directed edge
  std::map<int, int> corners;
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      if (!third.insert({{t[k], t[(k + 1) % 3]}, t[(k + 2) % 3]}).second)
        return "an edge is used twice in one direction";
      ++corners[t[k]];
    }
  if (corners.size() != mesh.vertices.size()) return "a vertex is in no triangle";
  for (const auto& [edge, unused] : third)
    if (!third.count({edge.second, edge.first})) return "an edge is open";
  // Around each vertex, step from triangle to triangle.
  std::map<int, int> anyNeighbor;
  for (const auto& [edge, unused] : third) anyNeighbor[edge.first] = edge.second;
  for (const auto& [vertex, count] : corners) {
    int steps = 0, at = anyNeighbor[vertex];
    do {
      at = third[{vertex, at}];
      ++steps;
    } while (at != anyNeighbor[vertex]);
    if (steps != count) return "several fans of triangles meet in a vertex";
  }
  return "";
}

using Corners = std::array<std::array<double, 3>, 3>;

/// A triangle by its coordinates, beginning with the smallest corner, in one of its two directions.
Corners facetOf(const TriangleMesh& mesh, int triangle, bool turned) {
  Corners c;
  for (int k = 0; k < 3; ++k) {
    const Vec3& v = mesh.corner(triangle, turned ? 2 - k : k);
    c[k] = {v.x(), v.y(), v.z()};
  }
  std::rotate(c.begin(), std::min_element(c.begin(), c.end()), c.end());
  return c;
}

double areaOf(const Corners& c) {
  const auto at = [&](int k) { return Vec3(c[k][0], c[k][1], c[k][2]); };
  return 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
}

std::vector<std::pair<std::string, CatScene>> scenes() {
  return {{"four cubes", fourCubes()},
          {"spheres and cubes", spheresAndCubes()},
          {"mixture", mixture()},
          {"red cells", redCellsInSphere(6, 0.45)},
          {"small red cells", redCellsInSphere(6, 0.45, 0.2)},
          {"one red cell", redCellsInSphere(1, 0.2)}};
}

std::vector<TriangleMesh> allParts(const CatCells& cells) {
  std::vector<TriangleMesh> parts = cells.cells;
  if (!cells.wallLayer.triangles.empty()) parts.push_back(cells.wallLayer);
  return parts;
}

/// The pairs of cells that have faces in common.
std::set<std::pair<int, int>> neighborsOf(const std::vector<TriangleMesh>& cells) {
  std::map<Corners, int> owner;
  std::set<std::pair<int, int>> pairs;
  for (int i = 0; i < static_cast<int>(cells.size()); ++i)
    for (int t = 0; t < static_cast<int>(cells[i].triangles.size()); ++t) {
      const auto other = owner.find(facetOf(cells[i], t, true));
      if (other != owner.end()) pairs.insert({other->second, i});
      owner[facetOf(cells[i], t, false)] = i;
    }
  return pairs;
}

}  // namespace

TEST_CASE("CAT cells are closed surfaces around their objects", "[cat]") {
  for (const auto& [name, scene] : scenes()) {
    const Tetrahedra t = tetrahedralise(scene.input);
    for (const WallFaces wall : {WallFaces::atWall, WallFaces::midGap}) {
      INFO(name << (wall == WallFaces::atWall ? ", at the wall" : ", mid-gap"));
      const CatCells cells = catCells(t, wall);
      REQUIRE(cells.cells.size() == scene.input.objects.size());
      for (std::size_t i = 0; i < cells.cells.size(); ++i) {
        CHECK(faultOf(cells.cells[i]) == "");
        const PlacedMesh& object = scene.input.objects[i];
        const MeshRelation relation =
            relate(*object.mesh, object.placement, MeshHierarchy(cells.cells[i]), Placement()).relation;
        CHECK(relation == MeshRelation::firstInside);
      }
      CHECK(cells.wallLayer.triangles.empty() == (wall == WallFaces::atWall));
      if (wall == WallFaces::midGap) CHECK(faultOf(cells.wallLayer) == "");
    }
  }
}

TEST_CASE("CAT cells away from the wall do not intersect themselves", "[cat]") {
  for (const CatScene& scene : {spheresAndCubes(), mixture()})
    for (TriangleMesh& cell : catCells(tetrahedralise(scene.input), WallFaces::midGap).cells)
      CHECK(repairClosed(cell, "cell").empty());
}

TEST_CASE("CAT cells fill the container", "[cat]") {
  for (const auto& [name, scene] : scenes()) {
    const Tetrahedra t = tetrahedralise(scene.input);
    for (const WallFaces wall : {WallFaces::atWall, WallFaces::midGap}) {
      INFO(name << (wall == WallFaces::atWall ? ", at the wall" : ", mid-gap"));
      double sum = 0.0;
      for (const TriangleMesh& part : allParts(catCells(t, wall))) {
        CHECK(signedVolume(part) > 0.0);
        sum += signedVolume(part);
      }
      CHECK(sum == Approx(scene.containerVolume()).epsilon(1e-9));
    }
  }
}

TEST_CASE("CAT cells share their faces, and every part of the container's surface belongs to a cell",
          "[cat]") {
  for (const auto& [name, scene] : scenes()) {
    const Tetrahedra t = tetrahedralise(scene.input);
    for (const WallFaces wall : {WallFaces::atWall, WallFaces::midGap}) {
      INFO(name << (wall == WallFaces::atWall ? ", at the wall" : ", mid-gap"));
      std::map<Corners, int> sides;  // a facet counts +1, the same one turned round -1
      for (const TriangleMesh& part : allParts(catCells(t, wall)))
        for (int n = 0; n < static_cast<int>(part.triangles.size()); ++n) {
          const Corners one = facetOf(part, n, false), other = facetOf(part, n, true);
          sides[std::min(one, other)] += one < other ? 1 : -1;
        }
      double outer = 0.0;
      for (const auto& [facet, count] : sides) {
        CHECK(std::abs(count) <= 1);
        if (count != 0) outer += areaOf(facet);
      }
      CHECK(outer == Approx(surfaceArea(scene.input.container->mesh())).epsilon(1e-9));
    }
  }
}

TEST_CASE("Every point of the container is in exactly one CAT cell", "[cat]") {
  std::mt19937 random(17);
  for (const auto& [name, scene] : scenes()) {
    const Tetrahedra t = tetrahedralise(scene.input);
    const Box box = boundingBox(scene.input.container->mesh());
    for (const WallFaces wall : {WallFaces::atWall, WallFaces::midGap}) {
      INFO(name << (wall == WallFaces::atWall ? ", at the wall" : ", mid-gap"));
      std::vector<MeshHierarchy> parts;
      for (const TriangleMesh& part : allParts(catCells(t, wall))) parts.emplace_back(part);
      for (int sample = 0; sample < 300; ++sample) {
        Vec3 p;
        for (int k = 0; k < 3; ++k)
          p[k] = std::uniform_real_distribution<double>(box.lo[k], box.hi[k])(random);
        const auto within = std::count_if(parts.begin(), parts.end(),
                                          [&](const MeshHierarchy& part) { return isInside(p, part, {}); });
        CHECK(within == isInside(p, *scene.input.container, {}));
      }
    }
  }
}

TEST_CASE("Four cubes in a flat cuboid have CAT cells of equal volume", "[cat]") {
  const CatScene scene = fourCubes();
  const CatCells cells = catCells(tetrahedralise(scene.input), WallFaces::atWall);
  const auto neighbors = neighborsOf(cells.cells);
  for (const std::pair<int, int>& side : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 3), std::pair(2, 3)})
    CHECK(neighbors.count(side) == 1);
  for (const TriangleMesh& cell : cells.cells) CHECK(signedVolume(cell) == Approx(4.0).epsilon(0.05));
}

TEST_CASE("Four spheres and two cubes in a sphere have the expected neighbours", "[cat]") {
  const CatScene scene = spheresAndCubes();
  const CatCells cells = catCells(tetrahedralise(scene.input), WallFaces::atWall);
  const auto neighbors = neighborsOf(cells.cells);
  // Objects 2k and 2k+1 are opposite each other; all others are neighbours.
  for (int i = 0; i < 6; ++i)
    for (int j = i + 1; j < 6; ++j)
      if (i / 2 != j / 2) CHECK(neighbors.count({i, j}) == 1);
}

TEST_CASE("CAT cells do not depend on the order of the objects", "[cat]") {
  CatScene scene = mixture();
  const CatCells before = catCells(tetrahedralise(scene.input), WallFaces::atWall);
  std::reverse(scene.input.objects.begin(), scene.input.objects.end());
  const CatCells after = catCells(tetrahedralise(scene.input), WallFaces::atWall);
  for (std::size_t i = 0; i < before.cells.size(); ++i) {
    CHECK(before.cells[i].vertices == after.cells[before.cells.size() - 1 - i].vertices);
    CHECK(before.cells[i].triangles == after.cells[before.cells.size() - 1 - i].triangles);
  }
}

TEST_CASE("CAT cells fill a periodic box", "[cat]") {
  for (const CatScene& scene : {coarse(redCellsInPeriodicBox(13.0, 0.35), 1, 0.85),
                                coarse(redCellsInPeriodicBox(9.0, 0.12), 2, 0.9)}) {
    const CatCells cells = catCells(tetrahedralise(scene.input), WallFaces::atWall);
    double sum = 0.0;
    for (std::size_t i = 0; i < cells.cells.size(); ++i) {
      CHECK(faultOf(cells.cells[i]) == "");
      sum += signedVolume(cells.cells[i]);
      const PlacedMesh& object = scene.input.objects[i];
      CHECK(relate(*object.mesh, object.placement, MeshHierarchy(cells.cells[i]), Placement()).relation ==
            MeshRelation::firstInside);
    }
    CHECK(sum == Approx(scene.input.period.prod()).epsilon(1e-9));
  }
}

TEST_CASE("CAT cells fill a periodic cylinder", "[cat]") {
  const CatScene scene = coarse(redCellsInPeriodicCylinder(0.3), 1, 0.85);
  const Tetrahedra t = tetrahedralise(scene.input);
  for (const WallFaces wall : {WallFaces::atWall, WallFaces::midGap}) {
    const CatCells cells = catCells(t, wall);
    double sum = 0.0;
    for (const TriangleMesh& cell : cells.cells) {
      CHECK(faultOf(cell) == "");
      sum += signedVolume(cell);
    }
    // Steiner points on the wall are not periodic.
    if (wall == WallFaces::atWall) CHECK(sum == Approx(scene.containerVolume()).epsilon(1e-2));
    if (wall == WallFaces::midGap) CHECK(sum < 0.9 * scene.containerVolume());
    CHECK(cells.wallLayer.triangles.empty());
  }
}

TEST_CASE("Touching parts of a surface get separate vertices", "[cat]") {
  // Two tetrahedra with a common edge, on opposite sides of it.
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  const auto add = [&](int a, int b, int c, int d) {
    mesh.triangles.insert(mesh.triangles.end(), {{a, c, b}, {a, b, d}, {b, c, d}, {a, d, c}});
  };
  add(0, 2, 3, 1);
  add(0, 4, 5, 1);
  REQUIRE(signedVolume(mesh) == Approx(1.0 / 3.0));
  CHECK(faultOf(mesh) != "");
  const TriangleMesh parts = separateTouchingParts(mesh);
  CHECK(faultOf(parts) == "");
  CHECK(parts.vertices.size() == 8);
  CHECK(signedVolume(parts) == Approx(1.0 / 3.0));
  const TriangleMesh whole = icosphere(2);
  CHECK(separateTouchingParts(whole).vertices.size() == whole.vertices.size());
}
