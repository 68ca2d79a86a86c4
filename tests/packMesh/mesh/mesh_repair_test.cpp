// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/mesh_repair.h"

#include "packMesh/core/error.h"
#include "packMesh/mesh/self_intersection.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

std::string refusalOf(TriangleMesh mesh) {
  const std::string message = test::messageOf<MeshError>([&] { repairClosed(mesh, "cell.stl"); });
  CHECK_THAT(message, Contains("cell.stl"));
  return message;
}

const Vec3 one = Vec3::Ones();

}  // namespace

TEST_CASE("repairClosed does not change valid meshes", "[geometry]") {
  for (const TriangleMesh& sound :
       {sample::box(-one, one), sample::sphere(one, 3.0, 12, 17), sample::torus(one, 3.0, 1.0, 30, 20),
        sample::straightTube(0.0, 10.0, 2.0, 11, 24)}) {
    TriangleMesh mesh = sound;
    REQUIRE(repairClosed(mesh, "x").empty());
    REQUIRE(mesh.vertices == sound.vertices);
    REQUIRE(mesh.triangles == sound.triangles);
  }
}

TEST_CASE("repairClosed repairs what can be repaired safely and reports it", "[geometry]") {
  const TriangleMesh sound = sample::torus(Vec3::Zero(), 3.0, 1.0, 30, 20);
  const double volume = signedVolume(sound);
  TriangleMesh mesh = sound;

  SECTION("a soup of triangles") {
    mesh.vertices.clear();
    mesh.triangles.clear();
    for (const Triangle& t : sound.triangles) {
      const int n = int(mesh.vertices.size());
      for (const int v : t) mesh.vertices.push_back(sound.vertices[v]);
      mesh.triangles.push_back({n, n + 1, n + 2});
    }
    const std::vector<std::string> repairs = repairClosed(mesh, "x");
    REQUIRE(repairs == std::vector<std::string>{"x: merged 3000 duplicate vertices"});
    REQUIRE(mesh.vertices.size() == 600);
  }
  SECTION("collapsed triangles and unused vertices") {
    mesh.triangles.push_back({3, 3, 4});
    mesh.vertices.push_back(Vec3(99, 99, 99));
    const std::vector<std::string> repairs = repairClosed(mesh, "x");
    REQUIRE(repairs ==
            std::vector<std::string>{"x: removed 1 collapsed triangle", "x: removed 1 unused vertex"});
    REQUIRE(boundingBox(mesh).hi.x() < 5.0);
  }
  SECTION("triangles turned at random") {
    std::mt19937 random(5);
    int turned = 0;
    for (Triangle& t : mesh.triangles)
      if (random() % 5 == 0) {
        std::swap(t[0], t[1]);
        ++turned;
      }
    const std::vector<std::string> repairs = repairClosed(mesh, "x");
    REQUIRE(repairs.size() == 1);
    REQUIRE(repairs[0] ==
            "x: flipped " + std::to_string(turned) + " triangles oriented against their neighbours");
  }
  SECTION("inside out") {
    flip(mesh);
    const std::vector<std::string> repairs = repairClosed(mesh, "x");
    REQUIRE(repairs == std::vector<std::string>{"x: flipped 1 surface that was inside out"});
  }
  SECTION("cracks from rounding") {
    const int copy = int(mesh.vertices.size());
    mesh.vertices.push_back(mesh.vertices[17] + Vec3(1e-7, -1e-7, 1e-7));
    bool replaced = false;
    for (Triangle& t : mesh.triangles)
      for (int& v : t)
        if (v == 17 && !replaced) {
          v = copy;
          replaced = true;
        }
    const std::vector<std::string> repairs = repairClosed(mesh, "x");
    REQUIRE(repairs ==
            std::vector<std::string>{"x: closed cracks by merging 1 vertex that differed by rounding"});
    REQUIRE(mesh.vertices.size() == 600);
  }
  REQUIRE(signedVolume(mesh) == Approx(volume));
  REQUIRE(repairClosed(mesh, "again").empty());
}

TEST_CASE("repairClosed orients enclosed surfaces as holes, and surfaces in holes as solid", "[geometry]") {
  for (int flips = 0; flips < 16; ++flips) {
    TriangleMesh mesh;
    const double edges[4] = {8.0, 6.0, 4.0, 2.0};
    for (int k = 0; k < 4; ++k) {
      // The fourth lies beside the third, in the hole that the second makes.
      const Vec3 at = k < 2 ? Vec3(0, 0, 0) : k == 2 ? Vec3(-0.9, 0, 0) : Vec3(2.3, 0, 0);
      const double half = k < 2 ? edges[k] / 2 : k == 2 ? 2.0 : 0.5;
      TriangleMesh part = sample::box(at - half * one, at + half * one);
      if (flips & (1 << k)) flip(part);
      sample::append(mesh, part);
    }
    repairClosed(mesh, "nested");
    REQUIRE(signedVolume(mesh) == Approx(512.0 - 216.0 + 64.0 + 1.0));
    REQUIRE(repairClosed(mesh, "again").empty());
  }
}

TEST_CASE("repairClosed rejects what is not a closed surface", "[geometry][messages]") {
  const TriangleMesh cube = sample::box(Vec3::Zero(), one);
  CHECK_THAT(refusalOf({}), Contains("no triangles"));
  CHECK_THAT(refusalOf({cube.vertices, {{0, 1, 99}}}), Contains("refers to vertex 99 of 8"));
  CHECK_THAT(refusalOf({cube.vertices, {{0, 0, 1}}}), Contains("all triangles of the mesh are collapsed"));
  TriangleMesh mesh = cube;
  mesh.vertices[2].y() = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(refusalOf(mesh), Contains("vertex 2 has a coordinate that is not a finite number"));
  mesh = cube;
  mesh.triangles.pop_back();
  CHECK_THAT(refusalOf(mesh),
             Contains("not closed: it has 3 open edges, the first from (1, 1, 0) to (1, 0, 1)"));
  mesh = cube;
  mesh.vertices.insert(mesh.vertices.end(), {Vec3(2, 0, 0), Vec3(2, 0, 1)});
  for (const Triangle& t : {Triangle{0, 8, 1}, Triangle{0, 4, 8}, Triangle{0, 9, 8}, Triangle{8, 9, 1},
                            Triangle{9, 4, 1}, Triangle{0, 1, 9}})
    mesh.triangles.push_back(t);
  CHECK_THAT(refusalOf(mesh), Contains("the surface is not"));
  mesh = cube;
  for (Vec3& v : mesh.vertices) v.z() *= 1e-12;
  CHECK_THAT(refusalOf(mesh), Contains("encloses no volume"));
  mesh = cube;
  for (Vec3& v : mesh.vertices) v.z() = 0.0;
  CHECK_THAT(refusalOf(mesh), Contains("the surface is flat, so that it encloses no volume"));
  mesh = cube;
  for (Triangle& t : mesh.triangles) t[2] = t[1];
  CHECK_THAT(refusalOf(mesh), Contains("all triangles of the mesh are collapsed"));
}

TEST_CASE("repairClosed moves parts apart that touch in vertices and edges", "[geometry]") {
  const auto repairedWith = [](const TriangleMesh& other, bool inverted, const std::string& vertices) {
    TriangleMesh mesh = sample::box(Vec3::Zero(), one);
    sample::append(mesh, other);
    if (inverted) flip(mesh);
    const std::vector<std::string> repairs = repairClosed(mesh, "x");
    CHECK(std::count(repairs.begin(), repairs.end(),
                     "x: moved parts of the surface apart that touched in " + vertices) == 1);
    return mesh;
  };
  for (const bool inverted : {false, true})
    for (const auto& [other, vertices] : {std::pair(sample::box(one, 2 * one), "1 vertex"),
                                          std::pair(sample::box({1, 1, 0}, {2, 2, 1}), "2 vertices")}) {
      TriangleMesh mesh = repairedWith(other, inverted, vertices);
      CHECK(mesh.vertices.size() == 16);
      CHECK(signedVolume(mesh) == Approx(2.0).epsilon(3e-3));
      CHECK(signedVolume(mesh) < 2.0);  // through the outside
      CHECK(repairClosed(mesh, "again").empty());
    }
}

TEST_CASE("repairClosed joins parts that have faces in common", "[geometry]") {
  for (const bool inverted : {false, true}) {
    TriangleMesh mesh = sample::box(Vec3::Zero(), one);
    TriangleMesh other = mesh;  // so that the diagonals of the common faces are the same
    for (Vec3& v : other.vertices) v.x() = 2.0 - v.x();
    flip(other);
    sample::append(mesh, other);
    if (inverted) flip(mesh);
    repairClosed(mesh, "x");
    CHECK(mesh.vertices.size() == 12);
    CHECK(signedVolume(mesh) == Approx(2.0));
  }
}

TEST_CASE("repairClosed finds surfaces that intersect themselves", "[geometry][messages]") {
  const TriangleMesh box = sample::box(Vec3::Zero(), one);
  std::vector<TriangleMesh> crossing(4, box);
  sample::append(crossing[0], sample::box(0.5 * one, 1.5 * one));
  sample::append(crossing[1], sample::sphere({0.5, 0.5, 2.0}, 1.0, 4, 5));  // a vertex touches a face
  crossing[2].vertices[7] = Vec3(0.4, 0.3, -0.2);                           // pulled through the far side
  crossing[3].vertices[7] = Vec3(0.5, 0.25, 0.0);                           // onto it
  crossing.push_back(sample::torus(Vec3::Zero(), 1.0, 1.2, 40, 20));        // too thick
  for (const TriangleMesh& mesh : crossing)
    CHECK_THAT(refusalOf(mesh), Contains("intersects itself: the triangles at ("));
}

namespace {

/// A box [0, 4] x [0, 1] x [0, 1] whose edge from (0, 0, 1) to (4, 0, 1) has `inner` more vertices on the
/// face y = 0, but none on the face z = 1: there triangles without area fill the gap, a fan or a strip.
TriangleMesh boxWithSeam(int inner, bool fan) {
  TriangleMesh mesh = sample::box(Vec3::Zero(), {4, 1, 1});
  auto& t = mesh.triangles;
  // y = 0 is {0, 1, 4}, {1, 5, 4}; the edge runs from 4 to 5.
  t.erase(std::remove(t.begin(), t.end(), Triangle{1, 5, 4}), t.end());
  std::vector<int> seam{4};
  for (int i = 1; i <= inner; ++i) {
    seam.push_back(int(mesh.vertices.size()));
    mesh.vertices.emplace_back(4.0 * i / (inner + 1), 0.0, 1.0);
  }
  seam.push_back(5);
  for (std::size_t i = 0; i + 1 < seam.size(); ++i) t.push_back({1, seam[i + 1], seam[i]});
  if (fan) {
    for (std::size_t i = 1; i + 1 < seam.size(); ++i) t.push_back({4, seam[i], seam[i + 1]});
  } else {  // from both ends to the middle
    std::size_t lo = 0, hi = seam.size() - 1;
    for (bool low = true; hi - lo > 1; low = !low) {
      if (low) {
        t.push_back({seam[lo], seam[lo + 1], seam[hi]});
        ++lo;
      } else {
        t.push_back({seam[lo], seam[hi - 1], seam[hi]});
        --hi;
      }
    }
  }
  return mesh;
}

}  // namespace

TEST_CASE("repairClosed removes triangles without area without moving the surface", "[geometry]") {
  for (const bool fan : {true, false})
    for (const bool insideOut : {false, true})
      for (const int inner : {1, 2, 3, 7, 30}) {
        CAPTURE(fan, insideOut, inner);
        TriangleMesh mesh = boxWithSeam(inner, fan);
        if (insideOut) flip(mesh);
        const std::size_t triangles = mesh.triangles.size();
        const std::vector<std::string> repairs = repairClosed(mesh, "x");
        REQUIRE(repairs.size() == (insideOut ? 2 : 1));
        CHECK(repairs[0] == "x: repaired " + std::to_string(inner) +
                                (inner == 1 ? " triangle without area" : " triangles without area"));
        CHECK(mesh.vertices.size() == 8u + inner);
        CHECK(mesh.triangles.size() == triangles);
        CHECK(signedVolume(mesh) == Approx(4.0));
        CHECK(surfaceArea(mesh) == Approx(18.0));
        CHECK(repairClosed(mesh, "x").empty());
      }
}

TEST_CASE("repairClosed rejects a corrupt coordinate and names the vertex", "[geometry][messages]") {
  const TriangleMesh tube = sample::straightTube(0.0, 12.0, 5.0, 2, 12);
  TriangleMesh soup;
  for (const Triangle& t : tube.triangles) {
    const int n = int(soup.vertices.size());
    for (const int v : t) soup.vertices.push_back(tube.vertices[v]);
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  for (const TriangleMesh& sound : {tube, soup})
    for (const double wrong : {1e9, -1e9, 1e6}) {
      TriangleMesh mesh = sound;
      mesh.vertices[4].x() = wrong;
      CHECK_THAT(refusalOf(mesh), Contains("the vertex at (" + std::string(wrong < 0 ? "-" : "") + "1e+0") &&
                                      Contains("a coordinate may be corrupt"));
    }
  // Nearer, but not by rounding: open edges of the soup stay open, with and without vertices further away.
  for (const double wrong : {12.001, 13.0, 1e3}) {
    TriangleMesh mesh = soup;
    mesh.vertices[4].x() = wrong;
    CHECK_THAT(refusalOf(mesh), Contains("not closed"));
  }
  // Cracks of rounding are closed as ever.
  TriangleMesh mesh = soup;
  mesh.vertices[4].x() += 1e-6;
  CHECK(repairClosed(mesh, "x").back() == "x: closed cracks by merging 1 vertex that differed by rounding");
  CHECK(mesh.vertices.size() == tube.vertices.size());
  // A long cone, and a coarse body beside a fine one, have nothing corrupt.
  mesh = sample::box(Vec3::Zero(), Vec3::Constant(1e6));
  sample::append(mesh, sample::sphere({-50, 0, 0}, 1.0, 12, 17));
  CHECK(repairClosed(mesh, "x").empty());
  mesh = sample::sphere(one, 1.0, 12, 17);
  mesh.vertices[0].z() = 1e3;
  CHECK(repairClosed(mesh, "x").empty());
}

TEST_CASE("findSelfIntersection is exact for touching and nearly touching parts", "[geometry]") {
  TriangleMesh mesh = sample::sphere({0, 0, 0}, 1.0, 8, 12);
  TriangleMesh near = sample::sphere({0, 0, 2.0}, 1.0, 8, 12);
  TriangleMesh both = mesh;
  sample::append(both, near);
  REQUIRE(findSelfIntersection(both));  // poles touch
  for (Vec3& v : near.vertices) v.z() += 1e-15;
  both = mesh;
  sample::append(both, near);
  REQUIRE_FALSE(findSelfIntersection(both));
}
