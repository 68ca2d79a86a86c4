// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/pov_scene.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <locale>

#include "packMesh/error.h"

using namespace packmesh;
namespace fs = std::filesystem;

namespace {

/// A folder of its own, removed at the end.
struct Scratch {
  fs::path path;
  Scratch() {
    std::string name = (fs::temp_directory_path() / "packmesh_pov_XXXXXX").string();
    REQUIRE(mkdtemp(name.data()));
    path = name;
  }
  ~Scratch() { fs::remove_all(path); }
};

std::string contents(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

Shape octahedron(double radius) {
  TriangleMesh mesh;
  for (int k = 0; k < 3; ++k)
    for (const double sign : {radius, -radius}) mesh.vertices.push_back(sign * Vec3::Unit(k));
  for (const int x : {0, 1})
    for (const int y : {2, 3})
      for (const int z : {4, 5}) {
        Triangle t{x, y, z};
        if (mesh.vertices[x].cross(mesh.vertices[y]).dot(mesh.vertices[z]) < 0) std::swap(t[1], t[2]);
        mesh.triangles.push_back(t);
      }
  return Shape(mesh, ellipsoidProfile(radius, radius, radius));
}

/// A box, with or without walls; scenes need no more of a container.
struct Lumen : Container, Wall {
  Box box;
  bool walls;
  Lumen(const Vec3& size, bool withWalls) : box{Vec3::Zero(), size}, walls(withWalls) {}

  Box bounds() const override { return box; }
  Vec3 period() const override { return walls ? Vec3(Vec3::Zero()) : box.size(); }
  double volume() const override { return box.volume(); }
  const Wall* wall() const override { return walls ? this : nullptr; }
  std::string describe() const override { return "box"; }
  TriangleMesh surface() const override {
    TriangleMesh mesh;
    for (int i = 0; i < 8; ++i) {
      const Vec3 upper(i & 1, i >> 1 & 1, i >> 2);
      mesh.vertices.push_back(box.lo + box.size().cwiseProduct(upper));
    }
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
  }
  WallDistance distance(const Vec3&) const override { return {}; }
  WallVerdict examine(const PlacedHierarchy&, double) const override { return {}; }
};

/// Decimal commas and grouped thousands, in a locale that need not be
/// installed.
struct Commas : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

PlacedCell at(int species, const Vec3& p) {
  return {species, {Mat3::Identity(), p}};
}

}  // namespace

TEST_CASE("A scene has one mesh per species and one instance per cell", "[io]") {
  const Scratch scratch;
  const Shape red = octahedron(4), platelet = octahedron(1);
  const Lumen tube({50, 26, 26}, true);
  const std::vector<PlacedCell> cells{at(0, {10, 13, 13}), at(1, {20, 13, 13}), at(0, {30, 13, 13}),
                                      at(0, {40, 13, 13})};
  const fs::path file = scratch.path / "cells.pov";
  writePovScene(file, {&red, &platelet}, {"RBC", "PLT"}, cells, tube);
  const std::string scene = contents(file);
  CHECK(count(scene, "mesh2 {") == 3);  // two species and its faces
  CHECK(count(scene, "object { Cell0 ") == 3);
  CHECK(count(scene, "object { Cell1 ") == 1);
  CHECK(scene.find("matrix <1,0,0,0,1,0,0,0,1,20,13,13>") != std::string::npos);
  CHECK(scene.find("nan") == std::string::npos);
  CHECK(std::distance(fs::directory_iterator(scratch.path), fs::directory_iterator()) == 1);
}

TEST_CASE("A rotation is written for POV-Ray's row vectors", "[io]") {
  const Scratch scratch;
  const Shape red = octahedron(4);
  Placement quarter{Mat3::Zero(), {1, 2, 3}};
  quarter.linear << 0, -1, 0, 1, 0, 0, 0, 0, 1;  // x to y
  const fs::path file = scratch.path / "cells.pov";
  writePovScene(file, {&red}, {"RBC"}, {{0, quarter}}, Lumen({50, 50, 50}, false));
  CHECK(contents(file).find("matrix <0,1,0,-1,0,0,0,0,1,1,2,3>") != std::string::npos);
}

TEST_CASE("A periodic box is drawn by its twelve edges, walls also by their faces", "[io]") {
  const Scratch scratch;
  const Shape red = octahedron(4);
  const fs::path file = scratch.path / "cells.pov";
  writePovScene(file, {&red}, {"RBC"}, {}, Lumen({50, 40, 30}, false));
  CHECK(count(contents(file), "cylinder {") == 12);
  CHECK(count(contents(file), "mesh2 {") == 1);
  writePovScene(file, {&red}, {"RBC"}, {}, Lumen({50, 40, 30}, true));
  // The sharp edges of the walls, not the diagonals of their triangles.
  CHECK(count(contents(file), "cylinder {") == 12);
  CHECK(count(contents(file), "mesh2 {") == 2);
}

TEST_CASE("Scenes are the same under a locale with decimal commas", "[io]") {
  const Scratch scratch;
  const Shape red = octahedron(3.91);
  const Lumen box({50.5, 50.5, 50.5}, false);
  const std::vector<PlacedCell> cells{at(0, {10.25, 13.5, 1234.5})};
  writePovScene(scratch.path / "a.pov", {&red}, {"RBC"}, cells, box);
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Commas));
  writePovScene(scratch.path / "b.pov", {&red}, {"RBC"}, cells, box);
  std::locale::global(before);
  CHECK(contents(scratch.path / "a.pov") == contents(scratch.path / "b.pov"));
  CHECK(contents(scratch.path / "a.pov").find("10.25,13.5,1234.5") != std::string::npos);
}

TEST_CASE("A scene that cannot be written is an error and leaves nothing", "[io]") {
  const Scratch scratch;
  const Shape red = octahedron(4);
  const Lumen box({50, 50, 50}, false);
  CHECK_THROWS_AS(writePovScene(scratch.path / "none" / "cells.pov", {&red}, {"RBC"}, {}, box), InputError);
  fs::create_directory(scratch.path / "taken.pov");
  CHECK_THROWS_AS(writePovScene(scratch.path / "taken.pov", {&red}, {"RBC"}, {}, box), InputError);
  CHECK(std::distance(fs::directory_iterator(scratch.path), fs::directory_iterator()) == 1);
}

TEST_CASE("POV-Ray renders every kind of scene, and the cells are in the picture", "[io]") {
  const Scratch scratch;
  const Shape red = octahedron(4), white = octahedron(5), own = octahedron(3);
  std::vector<PlacedCell> cells;
  for (int i = 0; i < 12; ++i)
    cells.push_back(at(i == 4 ? 1 : i == 7 ? 2 : 0, {6.0 + 12 * (i % 4), 8.0 + 9 * (i / 4), 13}));
  const Lumen lumen({50, 26, 26}, GENERATE(false, true));
  const fs::path file = scratch.path / "cells.pov", picture = scratch.path / "cells.ppm";
  writePovScene(file, {&red, &white, &own}, {"RBC", "WBC", "a name\n#error with a break"}, cells, lumen);
  const std::string command = "cd '" + scratch.path.string() + "' && '" POVRAY_EXECUTABLE "' +I" +
                              file.filename().string() + " +O" + picture.filename().string() +
                              " +FP +W80 +H60 -D -GA >log 2>&1";
  INFO(contents(scratch.path / "log"));
  REQUIRE(std::system(command.c_str()) == 0);

  // Binary PPM: header, then 80 x 60 pixels of three bytes.
  const std::string ppm = contents(picture);
  REQUIRE(ppm.size() > 80 * 60 * 3);
  const auto* pixel = reinterpret_cast<const unsigned char*>(ppm.data() + ppm.size() - 80 * 60 * 3);
  int reds = 0, whites = 0;
  for (int i = 0; i < 80 * 60; ++i, pixel += 3) {
    reds += pixel[0] > 2 * pixel[1];
    whites += pixel[0] > 220 && pixel[1] > 220;
  }
  CHECK(reds > 250);
  CHECK(whites > 500);
}
