// SPDX-License-Identifier: AGPL-3.0-or-later
// catCells, as users run it.
#include <sys/wait.h>

#include <cstdlib>

#include "packMesh/mesh/mesh_file.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/packMesh/write_mesh.h"
#include "tests/support/catch.h"
#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;

namespace {

struct RanCatCells {
  int exitCode;
  std::string text;
};

/// A folder with a container, a ball and some meshes that are at fault.
struct Meshes : test::TemporaryFolder {
  Meshes() {
    test::writeMesh(path() / "box.off", sample::box(Vec3::Constant(-4.0), Vec3::Constant(4.0)));
    const TriangleMesh ball = sample::sphere(Vec3::Zero(), 1.0, 8, 12);
    test::writeMesh(path() / "ball.off", ball);
    TriangleMesh open = ball;
    open.triangles.pop_back();
    test::writeMesh(path() / "open.off", open);
    TriangleMesh crossing = sample::torus(Vec3::Zero(), 1.0, 0.4, 16, 8);
    for (Vec3& v : crossing.vertices)
      if (v.x() > 1.0) v.x() -= 3.0;
    test::writeMesh(path() / "crossing.off", crossing);
    TriangleMesh flat = sample::box(Vec3::Constant(-1.0), Vec3::Constant(1.0));
    for (Vec3& v : flat.vertices) v.z() = 0.0;
    test::writeMesh(path() / "flat.off", flat);
  }
  RanCatCells run(const std::string& arguments) const {
    const std::string command = "cd '" + path().string() + "' && '" + test::programFolder + "/catCells' " +
                                arguments + " > text 2>&1 < /dev/null";
    const int status = std::system(command.c_str());
    std::ifstream in(path() / "text");
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, {std::istreambuf_iterator<char>(in), {}}};
  }
};

}  // namespace

TEST_CASE("catCells writes a cell for each object, and all surfaces", "[executable]") {
  const Meshes folder;
  for (const std::string kind : {"obj", "ply", "h5"}) {
    const RanCatCells ran =
        folder.run("box.off ball.off@-2,0,0 ball.off@2,0,0 --vtp c.vtp --output c." + kind);
    INFO(ran.text);
    REQUIRE(ran.exitCode == 0);
    CHECK_THAT(ran.text, Contains("ball.off@-2,0,0: cell of 236") && Contains("100.000000 %"));
    CHECK(std::filesystem::file_size(folder.path() / ("c." + kind)) > 1000);
  }
  for (const char* name : {"c.obj", "c.ply"})
    CHECK(signedVolume(readMesh(folder.path() / name)) == Approx(512.0));
  CHECK_THAT(test::readText(folder.path() / "c.obj"), Contains("\no ball.off@-2,0,0\n"));
  CHECK_THAT(test::readText(folder.path() / "c.ply"), Contains("\ncomment part 1 ball.off@2,0,0\n"));
  std::ifstream in(folder.path() / "c.vtp");
  const std::string surfaces{std::istreambuf_iterator<char>(in), {}};
  CHECK_THAT(surfaces, Contains("Name=\"object\"") && Contains("Name=\"cell\""));
  // With a layer along the wall cells are smaller.
  const RanCatCells ran = folder.run("box.off ball.off@-2,0,0 ball.off@2,0,0 --mid-gap");
  CHECK(ran.exitCode == 0);
  CHECK_THAT(ran.text, !Contains(": cell of 236") && Contains("100.000000 %"));
}

TEST_CASE("catCells explains errors", "[executable]") {
  const Meshes folder;
  const auto refused = [&](const std::string& arguments, int exitCode) {
    const RanCatCells ran = folder.run(arguments);
    CHECK(ran.exitCode == exitCode);
    CHECK_THAT(ran.text, Contains("(packMesh) (Error)"));
    CHECK(!std::filesystem::exists(folder.path() / "cells.obj"));
    return ran.text;
  };
  CHECK_THAT(refused("box.off ball.off open.off@2,2,2", 2), Contains("open.off") && Contains("open edge"));
  CHECK_THAT(refused("box.off ball.off crossing.off", 2), Contains("crossing.off"));
  CHECK_THAT(refused("box.off flat.off", 2), Contains("flat.off"));
  CHECK_THAT(refused("box.off ball.off ball.off@0.5,0,0", 2), Contains("ball.off and ball.off@0.5,0,0 meet"));
  CHECK_THAT(refused("box.off ball.off@9,0,0", 2), Contains("ball.off@9,0,0 is outside the container"));
  CHECK_THAT(refused("box.off ball.off@3.5,0,0", 2), Contains("ball.off@3.5,0,0 meets the container's wall"));
  CHECK_THAT(refused("box.off none.off", 2), Contains("none.off"));
  CHECK_THAT(refused("box.off ball.off@1,2", 1), Contains("@x,y,z"));
  CHECK_THAT(refused("box.off ball.off@1,two,3", 1), Contains("@1,two,3"));
  CHECK_THAT(refused("box.off", 1), Contains("at least one object"));
  CHECK_THAT(refused("box.off ball.off --colour", 1), Contains("--colour"));
  CHECK_THAT(refused("box.off ball.off --vtp", 1), Contains("--vtp needs a value"));
  // Before anything else: the container does not even exist.
  CHECK_THAT(refused("none.off ball.off --output cells.vtk", 2), Contains(".obj, .ply or .h5"));
}
