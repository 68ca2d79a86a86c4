// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/pov_scene.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>

#include "packMesh/core/error.h"
#include "tests/support/decimal_comma.h"

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

PicturedCell at(int species, const Vec3& p) {
  return {{species, {Mat3::Identity(), p}}, 0.01};
}

/// Colours of 80 x 60 pixels. @param declared what is set from outside
std::vector<unsigned char> rendered(const fs::path& file, const std::string& declared) {
  const fs::path folder = file.parent_path();
  const std::string command = "cd '" + folder.string() + "' && '" POVRAY_EXECUTABLE "' +I" +
                              file.filename().string() + " +Opicture.ppm +FP +W80 +H60 -D -GA " + declared +
                              " >log 2>&1";
  const bool good = std::system(command.c_str()) == 0;
  INFO(contents(folder / "log"));
  REQUIRE(good);
  constexpr std::size_t bytes = 80 * 60 * 3;  // after the head of a binary PPM
  const std::string ppm = contents(folder / "picture.ppm");
  REQUIRE(ppm.size() > bytes);
  return {ppm.end() - bytes, ppm.end()};
}

int countPixels(const std::vector<unsigned char>& pixels, bool (*is)(int, int, int)) {
  int n = 0;
  for (std::size_t i = 0; i < pixels.size(); i += 3) n += is(pixels[i], pixels[i + 1], pixels[i + 2]);
  return n;
}

}  // namespace

TEST_CASE("A scene has one mesh per species and one instance per cell", "[io]") {
  const Scratch scratch;
  const Shape red = octahedron(4), platelet = octahedron(1);
  const Lumen tube({50, 26, 26}, true);
  const std::vector<PicturedCell> cells{at(0, {10, 13, 13}), at(1, {20, 13, 13}), at(0, {30, 13, 13}),
                                        at(0, {40, 13, 13})};
  const fs::path file = scratch.path / "cells.pov";
  writePovScene(file, {&red, &platelet}, {"RBC", "PLT"}, cells, tube);
  const std::string scene = contents(file);
  CHECK(count(scene, "mesh2 {") == 3);  // two species and its faces
  CHECK(scene.find("At0 = array[3] {\n  <10,13,13>, <30,13,13>, <40,13,13>\n}") != std::string::npos);
  CHECK(scene.find("At1 = array[1] {\n  <20,13,13>\n}") != std::string::npos);
  CHECK(scene.find("Gap1 = array[1] {\n  0.01\n}") != std::string::npos);
  CHECK(scene.find("nan") == std::string::npos);
  CHECK(std::distance(fs::directory_iterator(scratch.path), fs::directory_iterator()) == 1);
}

TEST_CASE("A rotation is written as the images of x and y", "[io]") {
  const Scratch scratch;
  const Shape red = octahedron(4);
  Placement quarter{Mat3::Zero(), {1, 2, 3}};
  quarter.linear << 0, -1, 0, 1, 0, 0, 0, 0, 1;  // x to y
  const fs::path file = scratch.path / "cells.pov";
  writePovScene(file, {&red}, {"RBC"}, {{{0, quarter}, 0.0}}, Lumen({50, 50, 50}, false));
  CHECK(contents(file).find("X0 = array[1] {\n  <0,1,0>") != std::string::npos);
  CHECK(contents(file).find("Y0 = array[1] {\n  <-1,0,0>") != std::string::npos);
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

TEST_CASE("Scenes are the same in a locale with decimal commas", "[io]") {
  const Scratch scratch;
  const Shape red = octahedron(3.91);
  const Lumen box({50.5, 50.5, 50.5}, false);
  const std::vector<PicturedCell> cells{at(0, {10.25, 13.5, 1234.5})};
  writePovScene(scratch.path / "a.pov", {&red}, {"RBC"}, cells, box);
  auto comma = std::make_unique<test::DecimalComma>();
  writePovScene(scratch.path / "b.pov", {&red}, {"RBC"}, cells, box);
  comma.reset();
  CHECK(contents(scratch.path / "a.pov") == contents(scratch.path / "b.pov"));
  CHECK(contents(scratch.path / "a.pov").find("10.25,13.5,1234.5") != std::string::npos);
}

TEST_CASE("A scene that cannot be written is an error and leaves no file", "[io]") {
  const Scratch scratch;
  const Shape red = octahedron(4);
  const Lumen box({50, 50, 50}, false);
  CHECK_THROWS_AS(writePovScene(scratch.path / "none" / "cells.pov", {&red}, {"RBC"}, {}, box), OutputError);
  fs::create_directory(scratch.path / "taken.pov");
  CHECK_THROWS_AS(writePovScene(scratch.path / "taken.pov", {&red}, {"RBC"}, {}, box), OutputError);
  CHECK(std::distance(fs::directory_iterator(scratch.path), fs::directory_iterator()) == 1);
}

TEST_CASE("POV-Ray renders every kind of scene, and the picture shows the cells", "[io]") {
  const Scratch scratch;
  const Shape red = octahedron(4), white = octahedron(5), own = octahedron(3);
  std::vector<PicturedCell> cells;
  for (int i = 0; i < 12; ++i)
    cells.push_back(at(i == 4 ? 1 : i == 7 ? 2 : 0, {6.0 + 12 * (i % 4), 8.0 + 9 * (i / 4), 13}));
  const Lumen lumen({50, 26, 26}, GENERATE(false, true));
  const fs::path file = scratch.path / "cells.pov";
  writePovScene(file, {&red, &white, &own}, {"RBC", "WBC", "a name\n#error with a break"}, cells, lumen);
  const std::vector<unsigned char> pixels = rendered(file, "");
  int reds = 0, whites = 0;
  for (std::size_t i = 0; i < pixels.size(); i += 3) {
    reds += pixels[i] > 2 * pixels[i + 1];
    whites += pixels[i] > 220 && pixels[i + 1] > 220;
  }
  CHECK(reds > 250);
  CHECK(whites > 500);
}

TEST_CASE("Scenes can be cut, coloured and rotated by POV-Ray declarations", "[io]") {
  const Scratch scratch;
  const Shape red = octahedron(8);
  // To the left thin axes along y and gaps of 0, to the right along x and gaps of 1 µm.
  Placement turned{Mat3::Zero(), {38, 13, 13}};
  turned.linear << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  const std::vector<PicturedCell> cells{{{0, {Mat3::Identity(), {12, 13, 13}}}, 0.0}, {{0, turned}, 1.0}};
  const fs::path file = scratch.path / "cells.pov";
  writePovScene(file, {&red}, {"RBC"}, cells, Lumen({50, 26, 26}, GENERATE(false, true)));
  const auto isRed = [](int r, int g, int) { return r > 2 * g; };
  const auto isGreen = [](int r, int g, int) { return g > 2 * r; };
  const int all = countPixels(rendered(file, ""), isRed);
  REQUIRE(all > 60);
  const int half = countPixels(rendered(file, "Declare=ClipAxis=1"), isRed);
  // One cell is left, larger, as the camera comes nearer to what is shown.
  CHECK(half > 0.5 * all);
  CHECK(half < 1.2 * all);
  CHECK(countPixels(rendered(file, "Declare=ClipAxis=1 Declare=ClipAt=0.05"), isRed) == 0);
  // A plane through both: flat lids, paler than the cells.
  const auto isLid = [](int r, int g, int) { return r > g + 25 && r < 2 * g; };
  CHECK(countPixels(rendered(file, ""), isLid) < 80);
  CHECK(countPixels(rendered(file, "Declare=ClipAxis=2 Declare=ClipAt=0.47"), isLid) > 150);

  const std::vector<unsigned char> axes = rendered(file, "Declare=ColorBy=2");
  CHECK(countPixels(axes, isRed) > 0.3 * all);
  CHECK(countPixels(axes, isGreen) > 0.3 * all);
  const std::vector<unsigned char> gaps = rendered(file, "Declare=ColorBy=1");
  CHECK(countPixels(gaps, [](int r, int, int b) { return r > 2 * b && r > 100; }) > 0.3 * all);
  CHECK(countPixels(gaps, [](int r, int g, int b) { return b > g + 20 && b > r; }) > 0.3 * all);
  CHECK(rendered(file, "Declare=Azimuth=10 Declare=Elevation=60") != rendered(file, ""));
  for (const char* turn : {"0", "90", "215"}) {
    INFO(turn);
    const int seen = countPixels(rendered(file, std::string("Declare=Turn=") + turn), isRed);
    CHECK(seen > 0.15 * all);
    CHECK(seen < all);
  }
}

TEST_CASE("Scenes without cells, and with species without cells, can be rendered", "[io]") {
  const Scratch scratch;
  const Shape red = octahedron(4);
  const fs::path file = scratch.path / "cells.pov";
  const bool any = GENERATE(false, true);
  writePovScene(file, {&red, &red}, {"PLT", "RBC"},
                any ? std::vector{at(1, {10, 10, 10})} : std::vector<PicturedCell>(),
                Lumen({20, 20, 20}, true));
  const int reds =
      countPixels(rendered(file, "Declare=ClipAxis=2"), [](int r, int g, int) { return r > g + 25; });
  CHECK((reds > 50) == any);
}
