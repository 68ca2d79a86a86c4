// SPDX-License-Identifier: AGPL-3.0-or-later
// What check and packing say of cells that HemoCell deletes, of .pos files and of states, with the real
// executable.
#include "hemocell_adapter/session/examination.h"

#include <nlohmann/json.hpp>

#include "hemocell_adapter/hemocell/cell_model.h"
#include "hemocell_adapter/session/in_memory.h"
#include "packMesh/container/primitives.h"
#include "tests/hemocell_adapter/refusal.h"
#include "tests/support/catch.h"
#include "tests/support/deformed.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

namespace {

const TriangleMesh& redCell() {
  static const TriangleMesh mesh = buildTemplate(*defaultModel("RBC"), 0.5);
  return mesh;
}

/// Writes a state of deformed red cells at these positions, along x in a lumen with this period.
void writeDeformed(const std::filesystem::path& file, const std::vector<Vec3>& positions,
                   const Vec3& size = Vec3(25.5, 16, 16), double period = 25.5) {
  StateCells state;
  state.species.push_back({"RBC", redCell(), std::int64_t(positions.size())});
  for (const Vec3& position : positions) {
    Cell cell{std::int64_t(state.cells.size()), 0, {}};
    cell.pose.position = position;
    cell.vertices = deformed(redCell(), int(state.cells.size()) + 1);
    state.cells.push_back(std::move(cell));
  }
  state.record.origin = "a test, deformed cells";
  const Box box{Vec3::Zero(), size};
  saveCells(std::move(state), makeBox(box, {period > 0.0, false, false}), file);
}

}  // namespace

TEST_CASE("Of cells that cross a periodic face, only those are expected to go that have no other fault",
          "[executable][examination][long]") {
  const SampleCase folder;
  const auto checked = [&](const std::string& lines, int count) {
    writeText(folder / "RBC.pos", rbcPos(lines, count));
    return run(folder, "check config.xml --ends periodic --report report.json");
  };
  // 24 µm of tube at dx 0.5 µm are 51 nodes; its axis is at 8 µm, its wall at 15.5.
  const std::string crossing = "25 8 8 90 0 0\n";
  // Inside the wall, but the nodes next to some vertices are not.
  const std::string onWallNode = "12 8 11.5 0 0 0\n";
  for (const auto& [lines, count, code] : std::vector<std::tuple<std::string, int, int>>{
           {crossing, 1, 0}, {onWallNode, 1, 4}, {crossing + onWallNode, 2, 4}}) {
    const Ran ran = withExit(code, checked(lines, count));
    const auto report = readJson(folder / "report.json")["hemocell"];
    CHECK(report["dropped"] == count);
    CHECK(report["asExpected"] == (code == 0));
    CHECK(report["loadedBy"] == ".pos files");
    CHECK_THAT(ran.out, Contains("Cells not wholly inside the lumen: 0\n"));
    if (code == 0)
      CHECK_THAT(ran.out, Contains("deletes 1: crosses a periodic face\n") &&
                              Contains("Verdict: clean. HemoCell will delete 1 cell that crosses periodic "
                                       "faces, as expected\n"));
    else
      CHECK_THAT(ran.out, Contains("deletes 1: a vertex lies on a wall node") &&
                              Contains("Verdict: not clean\n") && !Contains("as expected"));
  }
  // A cell that crosses a face and has a vertex on a wall node beyond it.
  CHECK_THAT(withExit(4, checked("25 8 11.5 0 0 0\n", 1)).out,
             Contains("deletes 1: a vertex lies on a wall node"));
}

TEST_CASE("Of a state, check says what the plug-in keeps", "[executable][examination]") {
  const SampleCase folder;
  writeDeformed(folder / "flowing.h5", {Vec3(0, 8, 8), Vec3(12, 8, 8)});
  const Ran kept = ok(folder, "check config.xml --ends periodic --start flowing.h5 --report r.json");
  CHECK_THAT(kept.out,
             Contains("With loadParticles() HemoCell keeps 2 of 2 RBC\n") && Contains("Verdict: clean\n"));
  const auto report = readJson(folder / "r.json")["hemocell"];
  CHECK(report["kept"] == 2);
  CHECK(report["loadedBy"] == "plug-in");

  // Nearer to solid nodes than the loader of .pos files accepts, as cells of a run come.
  const std::string check = "check config.xml --ends periodic --start flowing.h5";
  writeDeformed(folder / "flowing.h5", {Vec3(0, 11, 8), Vec3(12, 11, 8)});
  CHECK_THAT(run(folder, check + " --minimum-distance-from-solid RBC 2").out,
             Contains("With loadParticles() HemoCell keeps 2 of 2 RBC\n"));
  writeDeformed(folder / "flowing.h5", {Vec3(0, 8, 8), Vec3(12, 13.5, 8)});
  CHECK_THAT(ended(folder, 4, check).out,
             Contains("With loadParticles() HemoCell keeps 1 of 2 RBC; deletes 1: a vertex lies on a "
                      "wall node"));
}

TEST_CASE("Closed ends are advised only where they help", "[executable][examination]") {
  const SampleCase folder;
  writeDeformed(folder / "flowing.h5", {Vec3(0, 8, 8), Vec3(12, 8, 8)});
  for (const char* option : {"--start", "--blood"}) {
    CAPTURE(option);
    const Ran ran = ok(folder, std::string("config.xml --ends periodic ") + option + " flowing.h5 --rbc 2");
    CHECK_THAT(ran.out, Contains("With loadParticles() HemoCell keeps 2 of 2 cells\n"));
    CHECK_THAT(ran.err, !Contains("HemoCell would keep") && !Contains("--ends closed"));
  }
  const TemporaryFolder box;
  CHECK_THAT(ok(box, "16 16 16 --ends periodic --rbc 12").err,
             Contains("when it loads them from .pos files; --ends closed packs cells that it keeps, the "
                      "plug-in (packmesh::loadParticles) keeps all of them"));
  // A box that is repeated must be periodic.
  CHECK_THAT(
      ok(box, "16 16 16 --ends periodic --rbc 12 --tile 2 1 1").err,
      Contains("HemoCell would keep") && Contains("packmesh::loadParticles") && !Contains("--ends closed"));
}

TEST_CASE("Cells that stay near the wall cause a warning", "[executable][examination][long]") {
  const TemporaryFolder folder;
  // Only platelets fit beside them.
  const std::string lumen = "--cylinder x 8 25.5 --ends periodic ";
  // Deformed cells, the nearest at the wall of a pipe of radius 8 µm.
  const auto warned = [&](double y) {
    writeDeformed(folder / "flowing.h5", {Vec3(5, 8, 8), Vec3(15, y, 8)}, Vec3(25.5, 16, 16));
    const Ran ran = ok(folder, lumen + "--blood flowing.h5");
    return ran.err;
  };
  CHECK_THAT(warned(8.0), !Contains("the cells stay where they were"));
  double y = 8.5;  // and nearer, in steps shorter than the clearance
  while (!Catch::contains(warned(y), "the cells stay where they were") && y < 15.0) y += 0.3;
  CHECK_THAT(warned(y), Contains("the nearest 0.") && Contains("--wall-clearance 0.5, or less, moves them"));
  CHECK_THAT(ok(folder, lumen + "--blood flowing.h5 --wall-clearance 0.4").err, !Contains("the cells stay"));
}

TEST_CASE("Meshes and pieces of blood that cannot be are refused with their place",
          "[executable][examination]") {
  const TemporaryFolder folder;
  const std::string lumen = "--cylinder x 8 25.5 --ends periodic --blood flowing.h5";
  const auto write = [&](const Vec3& scale, double period = 25.5) {
    StateCells state;
    state.species.push_back({"RBC", redCell(), 1});
    Cell cell{0, 0, {}};
    cell.pose.position = Vec3(7, 8, 9);
    for (const Vec3& v : redCell().vertices) cell.vertices.push_back(scale.cwiseProduct(v));
    state.cells.push_back(std::move(cell));
    state.record.origin = "a test, one cell";
    saveCells(std::move(state), makeBox({Vec3::Zero(), Vec3(period, 16, 16)}, {true, false, false}),
              folder / "flowing.h5");
  };
  write(Vec3(1, -1, 1));
  requireRefused(folder, {{lumen, 2, "the mesh of a cell 'RBC' near (7, 8, 9) µm is inside out"}});
  write(Vec3(1, 1e-9, 1));
  requireRefused(folder, {{lumen, 2, "the mesh of a cell 'RBC' near (7, 8, 9) µm is flat: it has"}});
  write(Vec3(1, 1, 1), 1e-3);
  requireRefused(folder,
                 {{lumen + " --max-time 5", 2,
                   "its cells would be repeated every 0.001 µm along x, which is less than they are thick"}});
  // Fixed cells that overlap are named by their numbers in the file.
  writeDeformed(folder / "flowing.h5", {Vec3(5, 8, 8), Vec3(15, 8, 8), Vec3(15.5, 8, 8)});
  requireRefused(folder, {{"--cylinder x 8 25.5 --ends periodic --fixed flowing.h5 --rbc 4", 2,
                           "cell 2 of 'RBC' and cell 3 of 'RBC', which stay where they are, overlap"}});
}
