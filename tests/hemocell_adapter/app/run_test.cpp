// SPDX-License-Identifier: AGPL-3.0-or-later
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "hemocell_adapter/app/run.h"
#include "hemocell_adapter/base/exit_codes.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/mesh/mesh_repair.h"
#include "tests/hemocell_adapter/executable.h"
#include "tests/hemocell_adapter/refusal.h"
#include "tests/packMesh/mesh/test_meshes.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/packMesh/write_mesh.h"
#include "tests/support/catch.h"

using namespace packmesh::hemocell;
using namespace packmesh::test;
using packmesh::temporaryName;
using packmesh::hemocell::ExitCode;
namespace fs = std::filesystem;

namespace {

const std::string small = "20 20 20 --rbc 3";

}  // namespace

TEST_CASE("A second run in the same folder is rejected and names the first", "[executable][long]") {
  const TemporaryFolder folder;
  {
    const RunLock held = RunLock::ofFolder(folder.path());
    for (const std::string more : {"", " --realisations 2"}) {
      const Ran second = ended(folder, int(ExitCode::cannotWrite), small + more);
      CHECK_THAT(second.err, Contains("another packMesh is writing into this folder (process " +
                                      std::to_string(getpid()) + " on "));
      CHECK_THAT(second.err, Contains("--output-dir"));
    }
    CHECK(folder.files() == 1);
    ok(folder, small + " --validate");
    ok(folder, small + " --dry-run");
    ok(folder, small + " --output-dir other");
    CHECK(run(folder / "other", "check --box 20 20 20").exitCode == 0);
    fs::copy_file(folder / "other/RBC.pos", folder / "RBC.pos");
    ok(folder, "check --box 20 20 20");
    CHECK_THROWS_AS(RunLock::ofFolder(folder.path()), packmesh::OutputError);
  }
  ok(folder, small);
  CHECK(folder.files() == 2);  // RBC.pos, other
}

TEST_CASE("A second run with the same state is rejected in any folder", "[executable][long]") {
  const TemporaryFolder folder;
  {
    const RunLock held = RunLock::ofFile(folder / "s.h5");
    CHECK_THAT(ended(folder, int(ExitCode::cannotWrite), small + " --output-dir other --state s.h5").err,
               Contains("s.h5: another packMesh is writing it (process "));
    CHECK(folder.files() == 1);  // the folder that stayed empty is gone
  }
  // What a killed run left of a state goes away; what other states have left stays, or is being written.
  const auto temporary = [&](const char* state) { return temporaryName(folder / state, 0, "new"); };
  for (const char* state : {"s", "s.h5", "t.h5"}) writeText(temporary(state), "half");
  ok(folder, small + " --state s");
  CHECK_FALSE(fs::exists(temporary("s")));
  CHECK(fs::exists(temporary("s.h5")));
  ok(folder, small + " --state s.h5");
  CHECK_FALSE(fs::exists(temporary("s.h5")));
  CHECK(fs::exists(temporary("t.h5")));
  CHECK(folder.files() == 4);  // RBC.pos, s, s.h5, what is left of t.h5
}

TEST_CASE("A lock ends with its process, however the process ends", "[executable]") {
  const TemporaryFolder folder;
  int ready[2];
  REQUIRE(pipe(ready) == 0);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    const RunLock held = RunLock::ofFolder(folder.path());
    [[maybe_unused]] const ssize_t told = write(ready[1], "!", 1);
    for (;;) pause();
  }
  char taken = 0;
  REQUIRE(read(ready[0], &taken, 1) == 1);
  ended(folder, int(ExitCode::cannotWrite), small);
  // What it was writing: the name has its number.
  const std::string own = std::to_string(getpid());
  std::string left = temporaryName(folder / "RBC.pos", 0, "new").filename().string();
  left.replace(left.rfind(own + "-"), own.size(), std::to_string(child));
  writeText(folder / left, "half");
  const auto other = temporaryName(folder / "report.json", 0, "new");  // of a process that lives
  writeText(other, "half");
  kill(child, SIGKILL);
  REQUIRE(waitpid(child, nullptr, 0) == child);
  close(ready[0]);
  close(ready[1]);
  CHECK(fs::exists(folder / ".packMesh.lock"));
  ok(folder, small);
  CHECK_FALSE(fs::exists(folder / left));
  CHECK(fs::exists(other));
  CHECK(folder.files() == 2);  // RBC.pos as well
}

TEST_CASE("A folder created by a run that wrote nothing is removed") {
  const TemporaryFolder folder;
  ended(folder, int(ExitCode::outOfReach),
        "15 15 15 --hematocrit 0.7 --max-iterations 20 --output-dir new/deep --state new/s.h5");
  // The state of what was not reached is kept, to go on.
  CHECK_FALSE(fs::exists(folder / "new/deep"));
  CHECK_FALSE(fs::exists(folder / "new/s.h5"));
  CHECK(fs::exists(folder / "new/s.checkpoint.h5"));
}

// Packing a case or a box, and what ends it, with the real executable.

using namespace packmesh;
using namespace packmesh::test;

TEST_CASE("A case is packed and certified, and HemoCell keeps all cells", "[executable]") {
  const SampleCase folder;
  const Ran packed = ok(folder, "config.xml --hematocrit 0.30 --plt_ratio 0.2 --seed 3");
  const int rbc = cellsIn(folder / "RBC.pos"), plt = cellsIn(folder / "PLT.pos");
  CHECK(rbc > 10);
  CHECK(plt == std::lround(0.2 * rbc));
  CHECK_THAT(packed.out,
             Contains("HemoCell keeps " + std::to_string(rbc + plt) + " of " + std::to_string(rbc + plt)));
  CHECK_THAT(packed.out, Contains("Certificate: clean"));
  CHECK_THAT(packed.out, !Contains("packCells"));  // by whose volume nobody counts here
  CHECK_THAT(packed.out, Contains("<Volume>"));

  const Ran checked = ok(folder, "check config.xml");
  CHECK_THAT(checked.out, Contains("Verdict: clean"));
  CHECK_THAT(checked.out, Contains("minimum distance from solid 0 µm (not set in case.cpp)"));

  // Same seed, same bytes; another seed, another packing.
  const std::string first = readText(folder / "RBC.pos");
  ok(folder, "config.xml --hematocrit 0.30 --plt_ratio 0.2 --seed 3");
  CHECK(readText(folder / "RBC.pos") == first);
  ok(folder, "config.xml --hematocrit 0.30 --plt_ratio 0.2 --seed 4");
  CHECK(readText(folder / "RBC.pos") != first);
}

TEST_CASE("The packing section is sufficient, and options override it", "[executable]") {
  const SampleCase folder(
      "<packing> <hematocrit> 0.2 </hematocrit> <species name=\"RBC\" minimumDistanceFromSolid=\"1\"/> "
      "</packing>");
  const Ran ran = ok(folder, "config.xml");
  const int n = cellsIn(folder / "RBC.pos");
  CHECK_FALSE(fs::exists(folder / "PLT.pos"));
  CHECK_THAT(ran.out, Contains("minimum distance from solid 1 µm"));
  ok(folder, "check config.xml");
  ok(folder, "config.xml --hematocrit 0.1");
  CHECK(cellsIn(folder / "RBC.pos") < n);
  ok(folder, "config.xml --rbc 3");
  CHECK(cellsIn(folder / "RBC.pos") == 3);
  ok(folder, "config.xml --output-dir new/folder");
  CHECK(cellsIn(folder / "new/folder/RBC.pos") == n);
}

TEST_CASE("Proximity to the density limit is computed from meshes, for any red cell volume", "[executable]") {
  const TemporaryFolder folder;
  const Ran packCells =
      ended(folder, 0, "20 20 20 --hematocrit 0.61 --plt_ratio 0", "packCells");  // 0.51 by mesh
  CHECK_THAT(packCells.err, !Contains("of the lumen: above"));
  const Ran counted = run(folder, "15 15 15 --rbc 26 --max-iterations 1 --best-effort");
  INFO(counted.all());
  CHECK_THAT(counted.err, Contains("fill 0.6249 of the lumen: above 0.62"));
}

TEST_CASE("A ratio that looks like a percentage gives a warning", "[executable]") {
  const TemporaryFolder folder;
  CHECK_THAT(ok(folder, "20 20 20 --hematocrit 0.02 --plt_ratio 7 --dry-run").err,
             Contains("a ratio of 7 is 7 PLT for each red cell, not per cent; 0.07 may be meant"));
  CHECK(run(folder, "20 20 20 --hematocrit 0.2 --plt_ratio 1 --dry-run").err.empty());
  const SampleCase file(
      "<packing> <hematocrit> 0.1 </hematocrit> <species name=\"RBC\"/> <species name=\"PLT\" ratio=\"5\"/> "
      "</packing>");
  CHECK_THAT(run(file, "config.xml --dry-run").err, Contains("0.05 may be meant"));
}

TEST_CASE("Cells in columns are packed more densely than random packings", "[executable]") {
  const TemporaryFolder folder;
  CHECK_THAT(
      ok(folder,
         "40 40 40 --hematocrit 0.63 --ends periodic --plt_ratio 0 --order columns --report report.json")
          .out,
      Contains("in columns"));
  ok(folder, "check --box 40 40 40 --ends periodic");
  const auto report = readJson(folder / "report.json");
  CHECK(report["configuration"]["order"] == "columns");
  CHECK(report["measures"]["orientation"][0]["nematic"] > 0.99);
  CHECK_THAT(ok(folder, "40 40 40 --hematocrit 0.63 --ends periodic --order columns --dry-run").out,
             Contains("In columns"));
}

TEST_CASE("An infeasible request reports the best result, writes only on request and keeps old files",
          "[executable]") {
  const TemporaryFolder folder;
  writeText(folder / "RBC.pos", "old");
  const std::string arguments = "15 15 15 --hematocrit 0.72 --plt_ratio 0 --max-iterations 300";
  Ran ran = ended(folder, 3, arguments);
  CHECK_THAT(ran.err, Contains("not feasible within the limits: ") && Contains("RBC packed, hematocrit 0.") &&
                          Contains("(the densest certified packing found; limits: 300 sweeps"));
  CHECK_THAT(ran.err, Contains("near") || Contains("above 0.62"));
  CHECK(readText(folder / "RBC.pos") == "old");
  ran = ok(folder, arguments + " --best-effort");
  CHECK(cellsIn(folder / "RBC.pos") > 0);
  ok(folder, "check --box 15 15 15");
}

TEST_CASE("A limit reached when nothing is left to do is not an error", "[executable][long]") {
  const TemporaryFolder folder;
  ok(folder, "60 60 60 --rbc 5 --max-iterations 1");
  // With more to do than there is time for on any machine, no density is called the largest.
  CHECK_THAT(ended(folder, 3, "80 80 80 --hematocrit 0.7 --max-time 1").err,
             !Contains("the densest certified") &&
                 (Contains("a certified packing; the time limit ended the search for the densest") ||
                  Contains("not even one cell") || Contains("reached before packing began")));
}

TEST_CASE("A time limit that expires before packing begins is reported", "[executable]") {
  const TemporaryFolder folder;
  CHECK_THAT(ended(folder, 3, "50 50 50 --rbc 1 --max-time 1e-9").err,
             Contains("the time limit of 1e-09 s was reached before packing began; nothing was written") &&
                 !Contains("hematocrit"));
}

TEST_CASE("Columns are suggested only where a random packing is not feasible", "[executable]") {
  const TemporaryFolder folder;
  for (const auto& [hematocrit, proposed] : {std::pair("0.3", false), {"0.64", true}}) {
    const Ran ran = ended(
        folder, 3, std::string("24 24 24 --ends periodic --max-iterations 1 --hematocrit ") + hematocrit);
    const std::size_t error = ran.err.find("(Error)");
    REQUIRE(error != ran.err.npos);
    CHECK((ran.err.find("--order columns", error) != ran.err.npos) == proposed);
  }
}

TEST_CASE("Ctrl-C ends the program cleanly", "[executable]") {
  const TemporaryFolder folder;
  // A shell's background jobs ignore SIGINT, python's do not; the signal comes when the run has told what it
  // packs.
  const TemporaryFolder scripts;
  writeText(scripts / "interrupt.py", R"(import signal, subprocess, sys
run = subprocess.Popen(sys.argv[1:], stdout=subprocess.PIPE)
run.stdout.readline()
run.send_signal(signal.SIGINT)
run.communicate()
sys.exit(run.returncode)
)");
  CHECK_THAT(withExit(130, runProcess(folder, "40 40 40 --hematocrit 0.65",
                                      "python3 '" + (scripts / "interrupt.py").string() + "'"))
                 .err,
             Contains("interrupted: nothing was written"));
  CHECK(fs::is_empty(folder.path()));
}

TEST_CASE("Help, reference and version are printed", "[executable]") {
  const TemporaryFolder folder;
  Ran ran = ok(folder, "--help");
  CHECK_THAT(ran.out, Contains("--hematocrit"));
  CHECK(run(folder, "--help", "packCells").exitCode == 0);
  ok(folder, "--reference");
  CHECK_THAT(run(folder, "--version").out, Contains("packMesh "));
  CHECK(fs::is_empty(folder.path()));
}

TEST_CASE("Flat openings of a vessel are capped: volume and packing are those of the capped mesh",
          "[executable][openings]") {
  const TemporaryFolder folder;
  const TriangleMesh whole = sample::straightTube(0.0, 30.0, 6.0, 7, 24);
  TriangleMesh open = whole;
  open.triangles.erase(std::remove_if(open.triangles.begin(), open.triangles.end(),
                                      [&](const Triangle& t) {
                                        return std::all_of(t.begin(), t.end(), [&](int v) {
                                          return whole.vertices[v].x() > 29.0;
                                        });
                                      }),
                       open.triangles.end());
  TriangleMesh closed = open;
  std::vector<CappedOpening> openings;
  repairClosed(closed, "closed", &openings);
  REQUIRE(openings.size() == 1);
  writeMesh(folder / "open.stl", open);
  writeMesh(folder / "closed.stl", closed);
  const std::string cells = " 2 --rbc 20 --ends periodic --open-axis x --report r.json";
  ok(folder, "--vessel closed.stl" + cells);
  const std::string pos = readText(folder / "RBC.pos");
  const auto lumen = [&] { return readJson(folder / "r.json")["lumen"]["volume"]; };
  const double volume = lumen();
  CHECK(volume == Approx(8.0 * signedVolume(whole)));
  const Ran capped = ok(folder, "--vessel open.stl" + cells);
  CHECK(readText(folder / "RBC.pos") == pos);
  CHECK(lumen() == volume);
  CHECK_THAT(capped.all(),
             Contains("open.stl: capped 1 flat opening (447.239 µm²); --flat-openings refuse makes"));
  requireRefused(folder, {{"--vessel open.stl" + cells + " --flat-openings refuse", 2,
                           "the surface is not closed: it has 24 open edges"}});
}

TEST_CASE("The time limit includes the preparation", "[executable]") {
  const TemporaryFolder folder;
  writeMesh(folder / "cell.off", icosphere(4, 4.0));
  const Ran ran = ended(folder, 3, "40 40 40 --cell-mesh a 3 cell.off --max-time 1e-6");
  CHECK_THAT(ran.all(), Contains("was reached before packing began; nothing was written"));
  CHECK_THAT(ran.out, !Contains("Lumen"));  // it ended during the preparation
  CHECK_FALSE(fs::exists(folder / "a.pos"));
}
