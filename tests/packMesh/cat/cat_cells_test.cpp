// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/cat_cells.h"
#include "packMesh/cat/tetrahedra.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/mesh_repair.h"
#include "tests/packMesh/cat/cat_scenes.h"
#include "tests/packMesh/cat/convex_clip.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::test;

namespace {

/// One tetrahedron of positive volume with given labels.
Tetrahedra single(const std::array<Vec3, 4>& points, const std::array<int, 4>& labels) {
  Tetrahedra t;
  t.points.assign(points.begin(), points.end());
  t.labels.assign(labels.begin(), labels.end());
  t.vertices = {0, 1, 2, 3};
  t.tetrahedra = {{0, 1, 2, 3}};
  if (volumeOf(t, 0) < 0.0) std::swap(t.tetrahedra[0][0], t.tetrahedra[0][1]);
  for (int b = 0; b < 4; ++b) t.bodies.push_back({b, Vec3::Zero(), true, 0});
  return t;
}

std::array<Vec3, 4> cornersOf(const Tetrahedra& t, int index) {
  return {t.corner(index, 0), t.corner(index, 1), t.corner(index, 2), t.corner(index, 3)};
}

/// -1 for the corners on a face's second side, 1 for those on its first, 0 for others; times the face's
/// normal points away from the corner.
int signOf(const ChordalFace& face, int k) {
  return (face.first >> k & 1) - (face.second >> k & 1);
}

/// Whether x is behind all faces of a single tetrahedron that constrain its corner k.
bool isBehind(const ChordalFaces& split, int k, const Vec3& x) {
  return std::all_of(split.faces.begin(), split.faces.end(), [&](const ChordalFace& face) {
    return signOf(face, k) * face.normal.dot(x - face.point) <= 0.0;
  });
}

/// The segment of a corner: the tetrahedron behind all planes that the corner has to stay behind.
ConvexBody segment(const Tetrahedra& t, const ChordalFaces& split, int tetrahedron, int k) {
  ConvexBody body = ConvexBody::tetrahedron(cornersOf(t, tetrahedron));
  Vec3 last = Vec3::Constant(std::nan(""));
  auto face = std::lower_bound(split.faces.begin(), split.faces.end(), tetrahedron,
                               [](const ChordalFace& f, int index) { return f.tetrahedron < index; });
  for (; face != split.faces.end() && face->tetrahedron == tetrahedron; ++face) {
    if (signOf(*face, k) == 0 || face->point == last) continue;  // pairs have a common plane
    body.cut(face->point, signOf(*face, k) * face->normal);
    last = face->point;
  }
  return body;
}

/// Volumes of all segments, by label; those of the container are left out where its planes are at the wall.
std::map<int, double> segmentVolumes(const Tetrahedra& t, const ChordalFaces& split, int index) {
  std::map<int, double> volumes;
  for (int k = 0; k < 4; ++k) {
    const int label = t.labels[t.tetrahedra[index][k]];
    if (!volumes.count(label)) volumes[label] = segment(t, split, index, k).volume();
  }
  return volumes;
}

std::array<Vec3, 4> randomCorners(std::mt19937& random, int kind) {
  std::normal_distribution<double> normal;
  std::array<Vec3, 4> corners;
  for (Vec3& p : corners) p = Vec3(normal(random), normal(random), normal(random));
  if (kind == 1) corners[3] = (corners[0] + corners[1] + corners[2]) / 3.0 + 1e-4 * corners[3];  // a sliver
  if (kind == 2)
    for (Vec3& p : corners) p = 1e-3 * p + Vec3(20.0, -30.0, 40.0);
  if (kind == 3) corners[1] = corners[0] + 1e-3 * corners[1];  // a short edge
  return corners;
}

/// All ways to label four corners.
std::vector<std::array<int, 4>> allLabels(int lowest) {
  std::vector<std::array<int, 4>> all;
  for (int code = 0; code < 256; ++code)
    all.push_back(
        {lowest + (code & 3), lowest + (code >> 2 & 3), lowest + (code >> 4 & 3), lowest + (code >> 6)});
  return all;
}

/// How often the labels occur, most frequent first.
std::vector<int> countsOf(const std::array<int, 4>& labels) {
  std::map<int, int> count;
  for (const int label : labels) ++count[label];
  std::vector<int> sorted;
  for (const auto& entry : count) sorted.push_back(entry.second);
  std::sort(sorted.rbegin(), sorted.rend());
  return sorted;
}

}  // namespace

TEST_CASE("The four cases have 1, 1, 3 and 12 faces", "[cat]") {
  const std::map<std::vector<int>, std::pair<ChordalCase, int>> table = {
      {{4}, {ChordalCase::none, 0}},
      {{3, 1}, {ChordalCase::threeOne, 1}},
      {{2, 2}, {ChordalCase::twoTwo, 1}},
      {{2, 1, 1}, {ChordalCase::twoOneOne, 3}},
      {{1, 1, 1, 1}, {ChordalCase::allDifferent, 12}}};
  std::mt19937 random(1);
  std::map<ChordalCase, int> seen;
  for (const std::array<int, 4>& labels : allLabels(wallLabel)) {
    const auto [kind, faces] = table.at(countsOf(labels));
    ++seen[kind];
    const ChordalPattern& pattern = chordalPattern(labels[0], labels[1], labels[2], labels[3]);
    CHECK(pattern.kind == kind);
    std::array<std::uint8_t, 4> order = pattern.order;
    std::sort(order.begin(), order.end());
    CHECK(order == std::array<std::uint8_t, 4>{0, 1, 2, 3});
    const Tetrahedra t = single(randomCorners(random, 0), labels);
    ChordalFaces split;
    splitChordally(t, WallFaces::midGap, split);
    CHECK(int(split.faces.size()) == faces);
    CHECK(split.tetrahedra[int(kind)] == (faces > 0));
    // Every face has corners on both of its sides, all corners of one label on the same.
    for (const ChordalFace& face : split.faces) {
      CHECK(face.tetrahedron == 0);
      CHECK(face.first != 0);
      CHECK(face.second != 0);
      CHECK((face.first & face.second) == 0);
      for (int k = 0; k < 4; ++k)
        for (int j = 0; j < k; ++j)
          if (labels[t.tetrahedra[0][j]] == labels[t.tetrahedra[0][k]])
            CHECK(signOf(face, j) == signOf(face, k));
    }
  }
  CHECK(seen[ChordalCase::threeOne] == 48);
  CHECK(seen[ChordalCase::twoTwo] == 36);
  CHECK(seen[ChordalCase::twoOneOne] == 144);
  CHECK(seen[ChordalCase::allDifferent] == 24);
}

TEST_CASE("Faces separate the corners on their sides, and segments have the total volume", "[cat]") {
  // Shares of the segments, from the definition: integrals over barycentric coordinates.
  const std::map<std::vector<int>, std::map<int, double>> shares = {
      {{3, 1}, {{3, 7.0 / 8.0}, {1, 1.0 / 8.0}}},
      {{2, 2}, {{2, 0.5}}},
      {{2, 1, 1}, {{2, 11.0 / 18.0}, {1, 7.0 / 36.0}}},
      {{1, 1, 1, 1}, {{1, 0.25}}}};
  std::mt19937 random(3);
  for (int kind = 0; kind < 4; ++kind)
    for (const std::array<int, 4>& labels : allLabels(0)) {
      const std::vector<int> counts = countsOf(labels);
      if (counts.size() == 1) continue;
      const Tetrahedra t = single(randomCorners(random, kind), labels);
      ChordalFaces split;
      splitChordally(t, WallFaces::midGap, split);
      for (const ChordalFace& face : split.faces) {
        CHECK(face.normal.norm() == Approx(1.0).epsilon(1e-12));
        for (int k = 0; k < 4; ++k)
          if (signOf(face, k) != 0)
            CHECK(signOf(face, k) * face.normal.dot(t.corner(0, k) - face.point) < 0.0);
      }
      const double tolerance =
          kind == 0 ? 1e-12 : 1e-8;  // others lose digits, as all flat and distant bodies do
      double sum = 0.0;
      for (const auto& [label, volume] : segmentVolumes(t, split, 0)) {
        const int corners = int(std::count(labels.begin(), labels.end(), label));
        CHECK(volume == Approx(shares.at(counts).at(corners) * volumeOf(t, 0)).epsilon(tolerance));
        sum += volume;
      }
      CHECK(sum == Approx(volumeOf(t, 0)).epsilon(tolerance));
    }
}

TEST_CASE("A point is in the segment of the surface with the largest sum of weights", "[cat]") {
  std::mt19937 random(4);
  std::exponential_distribution<double> exponential;
  for (const std::array<int, 4>& labels : allLabels(0)) {
    const Tetrahedra t = single(randomCorners(random, 0), labels);
    ChordalFaces split;
    splitChordally(t, WallFaces::midGap, split);
    for (int sample = 0; sample < 20; ++sample) {
      std::array<double, 4> weight;
      double total = 0.0;
      for (double& w : weight) total += w = exponential(random);
      Vec3 x = Vec3::Zero();
      std::map<int, double> sum;
      for (int k = 0; k < 4; ++k) {
        x += weight[k] / total * t.corner(0, k);
        sum[t.labels[t.tetrahedra[0][k]]] += weight[k] / total;
      }
      const auto heaviest = std::max_element(
          sum.begin(), sum.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
      for (int k = 0; k < 4; ++k)
        CHECK(isBehind(split, k, x) == (t.labels[t.tetrahedra[0][k]] == heaviest->first));
    }
  }
}

TEST_CASE("At the wall the whole gap belongs to the objects", "[cat]") {
  std::mt19937 random(5);
  for (const std::array<int, 4>& labels : allLabels(wallLabel)) {
    if (countsOf(labels).size() == 1) continue;
    const Tetrahedra t = single(randomCorners(random, 0), labels);
    ChordalFaces split;
    splitChordally(t, WallFaces::atWall, split);
    double sum = 0.0;
    for (const auto& [label, volume] : segmentVolumes(t, split, 0))
      if (label != wallLabel) sum += volume;
    CHECK(sum == Approx(volumeOf(t, 0)).epsilon(1e-12));
    for (const ChordalFace& face : split.faces)
      for (int k = 0; k < 4; ++k) {
        const bool wall = t.labels[t.tetrahedra[0][k]] == wallLabel;
        const double height = face.normal.dot(t.corner(0, k) - face.point);
        if (face.first >> k & 1) CHECK(height < (wall ? 1e-12 : 0.0));
        if (face.second >> k & 1) CHECK(height > (wall ? -1e-12 : 0.0));
      }
  }
}

TEST_CASE("Segments fill the free space of real tetrahedra", "[cat]") {
  for (const CatScene& scene : {fourCubes(), spheresAndCubes(), mixture(), redCellsInSphere(6, 0.45)}) {
    const Tetrahedra t = tetrahedralise(scene.input);
    for (const WallFaces wall : {WallFaces::atWall, WallFaces::midGap}) {
      ChordalFaces split;
      splitChordally(t, wall, split);
      double sum = 0.0;
      for (std::size_t i = 0; i < t.tetrahedra.size(); ++i) {
        const int n = int(i);
        const std::map<int, double> volumes = segmentVolumes(t, split, n);
        double own = 0.0;
        for (const auto& [label, volume] : volumes)
          if (wall == WallFaces::midGap || label != wallLabel || volumes.size() == 1) own += volume;
        CHECK(own == Approx(volumeOf(t, n)).epsilon(1e-6).margin(1e-9));
        sum += own;
      }
      CHECK(sum == Approx(scene.containerVolume() - scene.objectVolume()).epsilon(1e-9));
    }
  }
}

TEST_CASE("Splitting again leaves no trace of the first result", "[cat]") {
  const Tetrahedra large = tetrahedralise(spheresAndCubes().input), small = tetrahedralise(fourCubes().input);
  ChordalFaces fresh, used;
  splitChordally(small, WallFaces::atWall, fresh);
  splitChordally(large, WallFaces::midGap, used);
  splitChordally(small, WallFaces::atWall, used);
  REQUIRE(fresh.faces.size() == used.faces.size());
  CHECK(fresh.tetrahedra == used.tetrahedra);
  for (std::size_t f = 0; f < fresh.faces.size(); ++f) {
    CHECK(fresh.faces[f].point == used.faces[f].point);
    CHECK(fresh.faces[f].normal == used.faces[f].normal);
    CHECK(fresh.faces[f].tetrahedron == used.faces[f].tetrahedron);
    CHECK(fresh.faces[f].first == used.faces[f].first);
    CHECK(fresh.faces[f].second == used.faces[f].second);
  }
}

TEST_CASE("Segments of adjacent tetrahedra match on their common triangle", "[cat]") {
  std::mt19937 random(6);
  std::exponential_distribution<double> exponential;
  // The surface whose segment holds a point, from the planes of one tetrahedron.
  const auto surfaceAt = [](const Tetrahedra& t, const ChordalFaces& split, const Vec3& x) {
    std::set<int> found;
    for (int k = 0; k < 4; ++k)
      if (isBehind(split, k, x)) found.insert(t.labels[t.tetrahedra[0][k]]);
    return found;
  };
  for (int trial = 0; trial < 2000; ++trial) {
    std::array<Vec3, 4> corners = randomCorners(random, 0);
    std::uniform_int_distribution<int> anyLabel(0, 3);
    std::array<int, 4> labels{anyLabel(random), anyLabel(random), anyLabel(random), anyLabel(random)};
    const Tetrahedra one = single(corners, labels);
    corners[3] = randomCorners(random, 0)[3];
    labels[3] = anyLabel(random);
    const Tetrahedra other = single(corners, labels);
    ChordalFaces oneSplit, otherSplit;
    splitChordally(one, WallFaces::midGap, oneSplit);
    splitChordally(other, WallFaces::midGap, otherSplit);
    for (int sample = 0; sample < 10; ++sample) {
      double weight[3], total = 0.0;
      for (double& w : weight) total += w = exponential(random);
      const Vec3 x = (weight[0] * corners[0] + weight[1] * corners[1] + weight[2] * corners[2]) / total;
      const std::set<int> here = surfaceAt(one, oneSplit, x);
      REQUIRE(here.size() == 1);
      CHECK(here == surfaceAt(other, otherSplit, x));
    }
  }
}

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

bool isInside(const PlacedMesh& object, const TriangleMesh& cell) {
  return relate(*object.mesh, object.placement, MeshHierarchy(cell), Placement()).relation ==
         MeshRelation::firstInside;
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
  for (int i = 0; i < int(cells.size()); ++i)
    for (int t = 0; t < int(cells[i].triangles.size()); ++t) {
      const auto other = owner.find(facetOf(cells[i], t, true));
      if (other != owner.end()) pairs.insert({other->second, i});
      owner[facetOf(cells[i], t, false)] = i;
    }
  return pairs;
}

}  // namespace

TEST_CASE("CAT cells are closed surfaces around their objects, fill the container and share their faces",
          "[cat]") {
  for (const auto& [name, scene] : scenes()) {
    const Tetrahedra t = tetrahedralise(scene.input);
    for (const WallFaces wall : {WallFaces::atWall, WallFaces::midGap}) {
      INFO(name << (wall == WallFaces::atWall ? ", at the wall" : ", mid-gap"));
      const CatCells cells = catCells(t, wall);
      REQUIRE(cells.cells.size() == scene.input.objects.size());
      for (std::size_t i = 0; i < cells.cells.size(); ++i) {
        CHECK(faultOf(cells.cells[i]) == "");
        CHECK(isInside(scene.input.objects[i], cells.cells[i]));
      }
      CHECK(cells.wallLayer.triangles.empty() == (wall == WallFaces::atWall));
      if (wall == WallFaces::midGap) CHECK(faultOf(cells.wallLayer) == "");
      double volume = 0.0;
      std::map<Corners, int> sides;  // a facet counts +1, the same one turned round -1
      for (const TriangleMesh& part : allParts(cells)) {
        CHECK(signedVolume(part) > 0.0);
        volume += signedVolume(part);
        for (int n = 0; n < int(part.triangles.size()); ++n) {
          const Corners one = facetOf(part, n, false), other = facetOf(part, n, true);
          sides[std::min(one, other)] += one < other ? 1 : -1;
        }
      }
      CHECK(volume == Approx(scene.containerVolume()).epsilon(1e-9));
      double outer = 0.0;
      for (const auto& [facet, count] : sides) {
        CHECK(std::abs(count) <= 1);
        if (count != 0) outer += areaOf(facet);
      }
      CHECK(outer == Approx(surfaceArea(scene.input.container->mesh())).epsilon(1e-9));
    }
  }
}

TEST_CASE("CAT cells away from the wall do not intersect themselves", "[cat]") {
  for (const CatScene& scene : {spheresAndCubes(), mixture()})
    for (TriangleMesh& cell : catCells(tetrahedralise(scene.input), WallFaces::midGap).cells)
      CHECK(repairClosed(cell, "cell").empty());
}

TEST_CASE("Every point of the container is in exactly one CAT cell", "[cat][long]") {
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

TEST_CASE("Cubes and spheres have the expected neighbours, and equal ones cells of equal volume", "[cat]") {
  const CatCells four = catCells(tetrahedralise(fourCubes().input), WallFaces::atWall);
  for (const std::pair<int, int>& side : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 3), std::pair(2, 3)})
    CHECK(neighborsOf(four.cells).count(side) == 1);
  for (const TriangleMesh& cell : four.cells) CHECK(signedVolume(cell) == Approx(4.0).epsilon(0.05));
  // Objects 2k and 2k+1 are opposite each other; all others are neighbours.
  const auto six = neighborsOf(catCells(tetrahedralise(spheresAndCubes().input), WallFaces::atWall).cells);
  for (int i = 0; i < 6; ++i)
    for (int j = i + 1; j < 6; ++j)
      if (i / 2 != j / 2) CHECK(six.count({i, j}) == 1);
}

TEST_CASE("CAT cells fill a periodic box", "[cat]") {
  for (const CatScene& scene : {coarse(redCellsInPeriodicBox(13.0, 0.35), 1, 0.85),
                                coarse(redCellsInPeriodicBox(9.0, 0.12), 2, 0.9)}) {
    const CatCells cells = catCells(tetrahedralise(scene.input), WallFaces::atWall);
    double sum = 0.0;
    for (std::size_t i = 0; i < cells.cells.size(); ++i) {
      CHECK(faultOf(cells.cells[i]) == "");
      sum += signedVolume(cells.cells[i]);
      CHECK(isInside(scene.input.objects[i], cells.cells[i]));
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
