// SPDX-License-Identifier: AGPL-3.0-or-later
// Soft cells, with the real executable.
#include <nlohmann/json.hpp>

#include "hemocell_adapter/hemocell/cell_model.h"
#include "tests/hemocell_adapter/refusal.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::test;

namespace {

/// Beyond what undeformed cells can fill, and small: 9 red cells, 1 platelet.
const std::string dense = "10 10 10 --ends periodic --hematocrit 0.73 --soft ";

/// Of a packing of soft cells that does not succeed, but leaves a checkpoint of those that were soft.
Ran failed(const TemporaryFolder& folder, const std::string& arguments, int code) {
  Ran ran = ended(folder, code, arguments + " --state s.h5");
  CHECK_FALSE(std::filesystem::exists(folder / "s.h5"));
  return ran;
}

}  // namespace

TEST_CASE("Soft cells fill a box beyond what undeformed ones can, and are saved as a state", "[executable]") {
  const TemporaryFolder folder;
  CHECK_THAT(ok(folder, dense + "--state s.h5 --report r.json").out,
             Contains("RBC: soft, kLink 15, kBend 80, kVolume 20, kArea 5 (HemoCell's cell templates)") &&
                 Contains("Deformed cells: 10; largest force on a vertex"));
  const std::string check = ok(folder, "check --box 10 10 10 --ends periodic --start s.h5").out;
  CHECK_THAT(check, Contains("RBC: 9 cells") && Contains("PLT: 1 cells") && Contains("Verdict: clean"));
  const auto report = readJson(folder / "r.json");
  CHECK(report["deformation"]["cells"] == 10);
  CHECK(report["deformation"]["largest"]["force"] > 0.1);
  CHECK(report["deformation"]["largest"]["force"] < 10.0);
  CHECK(std::abs(report["deformation"]["largest"]["volume"].get<double>()) < 0.01);
  CHECK(report["configuration"]["hematocrit"] == 0.73);
  CHECK(report["species"][0]["request"] == "by hematocrit");
}

TEST_CASE("Deformed cells that exist are in no need of the room of undeformed ones", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "10 10 10 --ends periodic --rbc 10 --soft --state s.h5");  // 0.81 of the box
  for (const std::string way : {"--start s.h5", "--fixed s.h5 --plt 1"}) {
    CHECK_THAT(ok(folder, "10 10 10 --ends periodic --dry-run " + way).out, Contains("Feasible"));
    CHECK_THAT(ok(folder, "10 10 10 --ends periodic --output-dir o " + way).out,
               Contains("RBC: 10 of 10 placed") && !Contains("no random packing"));
  }
}

TEST_CASE("Soft cells fold in a capillary", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "--cylinder x 2.8 20 --ends periodic --rbc 1 --soft --state s.h5");
  CHECK_THAT(ok(folder, "check --cylinder x 2.8 20 --ends periodic --start s.h5").out,
             Contains("RBC: 1 cells") && Contains("Verdict: clean"));
}

TEST_CASE("Soft cells begin farther from the wall of a mesh than distances to it are accurate",
          "[executable]") {
  SampleCase folder;
  writeText(
      folder / "config.xml",
      configXml(
          "<geometry> tube.stl </geometry> <dx> 5e-7 </dx> <refDir> 1 </refDir> <refDirN> 16 </refDirN>"));
  CHECK_THAT(ok(folder, "config.xml --rbc 4 --soft --max-force 3 --state s.h5").out,
             Contains("Deformed cells: 4") && Contains("HemoCell keeps 4 of 4 cells"));
}

TEST_CASE("Cells that need not deform are those of a packing without --soft", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "16 16 16 --ends periodic --hematocrit 0.3 --soft");
  const std::string soft = readText(folder / "RBC.pos");
  ok(folder, "16 16 16 --ends periodic --hematocrit 0.3");
  CHECK(readText(folder / "RBC.pos") == soft);
}

TEST_CASE("Cells are soft where undeformed ones are found in a short search, but not with clearances",
          "[executable][long]") {
  const TemporaryFolder folder;
  CHECK_THAT(ok(folder,
                "--cylinder x 8 31.5 --ends periodic --hematocrit 0.45 --plt_ratio 0.25 --profile developed "
                "--seed 4 --max-iterations 1500 --soft --state s.h5")
                 .out,
             Contains("Deformed cells: 44"));
}

TEST_CASE("A packing of undeformed cells that is continued with --soft ends with soft ones",
          "[executable][long]") {
  const TemporaryFolder folder;
  ended(folder, 3, "20 20 20 --ends periodic --rbc 63 --state s.h5 --max-iterations 40");
  CHECK_THAT(ok(folder, "--restart s.checkpoint.h5 --soft --max-iterations 400").out,
             Contains("Continuing from s.checkpoint.h5") && Contains("Deformed cells: 63"));
}

TEST_CASE("Soft cells that cannot be packed within the limits are refused, and it is said why",
          "[executable][long]") {
  const TemporaryFolder folder;
  CHECK_THAT(failed(folder, dense + "--max-force 0.05 --max-iterations 120", 3).err,
             Contains("the largest force on a vertex was") && Contains("0.05 pN are allowed (--max-force)"));
  CHECK_THAT(failed(folder, dense + "--max-area-change 0.01 --max-iterations 120", 3).err,
             Contains("the area of a cell changed by -") && Contains("1 % are allowed (--max-area-change)"));
  CHECK_THAT(failed(folder, dense + "--max-volume-change 1e-6 --max-iterations 120", 3).err,
             Contains("the volume of a cell changed by") && Contains("0.0001 % are allowed"));
  // They keep to the limits, and it is not said that they exceed one.
  CHECK_THAT(failed(folder, dense + "--max-iterations 36", 3).err,
             Contains("the cells have their full size, but had not come to rest after 36 iterations"));
  CHECK_THAT(failed(folder, dense + "--max-iterations 20", 3).err,
             Contains("the cells had grown to") && Contains("after 20 iterations"));
  CHECK_THAT(failed(folder, "--cylinder x 1.2 20 --ends periodic --rbc 1 --soft --max-iterations 50", 3).err,
             Contains("soft cells could not be packed within the limits"));
}

TEST_CASE("With best effort, soft cells that find no room are left out, and it is said how many",
          "[executable][long]") {
  const TemporaryFolder folder;
  const std::string asked = "10 10 10 --ends periodic --rbc 12 --soft --best-effort --max-iterations 100 ";
  const Ran ran = ok(folder, asked + "--state s.h5 --report r.json");
  CHECK_THAT(ran.err,
             Contains("soft cells could not be packed within the limits") &&
                 Contains("without those that found no room there is a packing with hematocrit 0.") &&
                 Contains("of 12 RBC); writing that one (--best-effort)"));
  const auto report = readJson(folder / "r.json");
  CHECK(report["outcome"] == "bestEffort");
  CHECK(report["species"][0]["asked"] == 12);
  const int placed = report["species"][0]["placed"];
  CHECK(placed >= 9);
  CHECK(placed < 12);
  CHECK(report["deformation"]["cells"] == placed);
  CHECK(report["deformation"]["largest"]["force"] <= 10.0);
  CHECK_THAT(ran.out, Contains("RBC: " + std::to_string(placed) + " of 12 placed"));
  CHECK_THAT(ok(folder, "check --box 10 10 10 --ends periodic --start s.h5").out,
             Contains("RBC: " + std::to_string(placed) + " cells") && Contains("Verdict: clean"));
  // At full size, but deformed too much.
  CHECK_THAT(ok(folder, dense + "--best-effort --max-force 0.8 --max-iterations 600 --state t.h5").err,
             Contains("the largest force on a vertex was") && Contains("writing that one"));
}

TEST_CASE("With best effort, undeformed cells are packed where no soft ones can be", "[executable][long]") {
  const TemporaryFolder folder;
  const Ran ran = ok(folder, dense + "--best-effort --max-force 1e-6 --max-iterations 100 --report r.json");
  CHECK_THAT(ran.err, Contains("1e-06 pN are allowed") &&
                          Contains("; of undeformed cells there is a packing with hematocrit 0.") &&
                          Contains("of 9 RBC, ") && Contains("writing that one (--best-effort)"));
  CHECK_THAT(ran.out, !Contains("Deformed cells:"));
  const auto report = readJson(folder / "r.json");
  CHECK(report["outcome"] == "bestEffort");
  CHECK(report["species"][0]["asked"] == 9);
  CHECK_THAT(ok(folder, "check --box 10 10 10 --ends periodic").out, Contains("Overlapping pairs: 0"));
  CHECK_THAT(failed(folder,
                    "--cylinder x 2.8 20 --ends periodic --rbc 1 --soft --best-effort --max-force 1e-6 "
                    "--max-iterations 100",
                    3)
                 .err,
             Contains("not even one undeformed cell could be packed; nothing was written"));
}

TEST_CASE("With auto, cells are soft only where undeformed ones cannot be packed", "[executable][long]") {
  const TemporaryFolder folder;
  // More than is tried before cells become soft without auto.
  const std::string possible = "16 16 16 --ends periodic --hematocrit 0.585 ";
  CHECK_THAT(ok(folder, possible + "--soft --state s.h5").out, Contains("Deformed cells:"));
  const TemporaryFolder automatic;
  CHECK_THAT(ok(automatic, possible + "--soft=auto").out,
             Contains("Undeformed cells could be packed: none are soft") && !Contains("Deformed cells:"));
  const std::string packed = readText(automatic / "RBC.pos");
  ok(folder, possible);
  CHECK(readText(folder / "RBC.pos") == packed);
  const Ran soft =
      ok(folder, "10 10 10 --ends periodic --hematocrit 0.73 --soft=auto --state u.h5 --report r.json");
  CHECK_THAT(soft.out, Contains("Undeformed cells cannot be packed as requested: cells are soft") &&
                           Contains("Deformed cells: 10"));
  CHECK(readJson(folder / "r.json")["configuration"]["soft"] == "auto");
  ok(folder, dense + "--state s.h5");
  CHECK_THAT(ok(folder, "--cylinder x 2.8 20 --ends periodic --rbc 1 --soft=auto --state v.h5").out,
             Contains("cells are soft") && Contains("Deformed cells: 1"));
  CHECK_THAT(run(folder, dense + "--soft=maybe").err, Contains("expected true, false or auto"));
}

TEST_CASE("A signal and the time limit end packing soft cells, and a restart continues",
          "[executable][long]") {
  const TemporaryFolder folder, scripts;
  // The signal comes when cells are soft, as the first line of progress of that stage says.
  writeText(scripts / "end.py", R"(import signal, subprocess, sys
run = subprocess.Popen(sys.argv[1:], stdout=subprocess.PIPE, text=True)
for line in run.stdout:
    if "soft cells: iteration" in line:
        run.send_signal(signal.SIGTERM)
sys.exit(run.wait())
)");
  // So much is never at rest below so little force.
  const std::string endless = "10 10 10 --ends periodic --hematocrit 0.73 --soft --max-force 1e-6 --verbose";
  CHECK_THAT(withExit(130, runProcess(folder, endless + " --state s.h5",
                                      "python3 '" + (scripts / "end.py").string() + "'"))
                 .err,
             Contains("to continue: packMesh --restart s.checkpoint.h5"));
  CHECK_FALSE(std::filesystem::exists(folder / "s.h5"));
  CHECK_THAT(ok(folder, "--restart s.checkpoint.h5 --max-force 10").out,
             Contains("Continuing from s.checkpoint.h5: after ") && Contains(" iterations of soft cells") &&
                 Contains("Deformed cells: 10"));
  CHECK_FALSE(std::filesystem::exists(folder / "s.checkpoint.h5"));
  CHECK_THAT(run(folder, "--restart s.h5").err,
             Contains("s.h5: is the result of packing soft cells; --start s.h5 takes its cells"));
  std::filesystem::remove(folder / "s.h5");
  CHECK_THAT(failed(folder, endless + " --max-time 2", 3).err, Contains("within the limits (2 s)"));
}

TEST_CASE("Soft cells that ended at limits continue on any number of ranks to the same state",
          "[executable][mpi][long]") {
  // The limit holds for the undeformed cells with which packing begins, too.
  const auto packed = [](const std::vector<std::pair<int, int>>& limitsAndRanks) {
    const TemporaryFolder folder;
    std::string restart;
    for (const auto& [limit, ranks] : limitsAndRanks) {
      const std::string arguments =
          restart + dense + "--state s.h5 --max-iterations " + std::to_string(limit);
      const Ran ran = ranks > 1 ? runProcess(folder, arguments, "OMP_NUM_THREADS=1 " + onRanks(ranks))
                                : run(folder, arguments);
      INFO(ran.all());
      const bool ends = limit == limitsAndRanks.back().first;
      REQUIRE(ran.exitCode == (ends ? 0 : 3));
      CHECK(std::filesystem::exists(folder / "s.checkpoint.h5") == !ends);
      if (!ends)
        CHECK_THAT(ran.out, Contains("To continue with higher limits: packMesh --restart s.checkpoint.h5 "
                                     "--max-iterations NUMBER\n"));
      if (!restart.empty()) CHECK_THAT(ran.out, Contains(" iterations of soft cells"));
      restart = "--restart s.checkpoint.h5 ";
    }
    return readText(folder / "s.h5");
  };
  const std::string expected = packed({{30, 1}, {500, 1}});
  CHECK((packed({{30, 1}, {500, 2}}) == expected));
  CHECK((packed({{30, 2}, {40, 4}, {500, 1}}) == expected));
}

TEST_CASE("A checkpoint of soft cells is refused by another request", "[executable]") {
  const TemporaryFolder folder;
  failed(folder, dense + "--max-iterations 20", 3);
  const std::string restart = "--restart s.checkpoint.h5 ";
  const std::string state = " --state s.h5", another = "is the state of another problem";
  requireRefused(folder, {
                             {restart + dense + "--seed 2" + state, 2, another},
                             {restart + dense + "--clearance 0.02" + state, 2, another},
                             {restart + dense + "--plt_ratio 0.2" + state, 2, another},
                             {restart + dense + "--rigid PLT" + state, 2, "have other membranes"},
                             {restart + "10 10 10 --ends periodic --hematocrit 0.73" + state, 2,
                              "s.checkpoint.h5: is the state of soft cells (--soft)"},
                             {"--start s.checkpoint.h5 " + dense + state, 2, "has cells that still grow"},
                         });
}

TEST_CASE("Membranes have the constants of a cell's XML file, all of them", "[executable]") {
  SampleCase folder;
  const auto cell = [&](const std::string& constants) {
    writeText(folder / "RBC.xml", cellXml("RBC", 3.91, 600, constants));
  };
  const std::string asked = "config.xml --rbc 2 --soft";
  cell("<kLink> 15 </kLink> <kBend> 80 </kBend> <kVolume> 20 </kVolume>");
  requireRefused(folder, {{asked, 2, "<kArea> is missing"}});
  ok(folder, asked + " --rigid RBC");
  cell("<kLink> 30 </kLink> <kBend> 80 </kBend> <kVolume> 20 </kVolume> <kArea> -5 </kArea>");
  requireRefused(folder, {{asked, 2, "<kArea> '-5', expected a number that is not negative"}});
  cell("<kLink> 30 </kLink> <kBend> 80 </kBend> <kVolume> 20 </kVolume> <kArea> 5 </kArea>");
  CHECK_THAT(ok(folder, asked).out, Contains("RBC: soft, kLink 30, kBend 80, kVolume 20, kArea 5 (RBC.xml)"));
}

TEST_CASE("Where undeformed cells do not fit, messages name --soft", "[executable]") {
  const TemporaryFolder folder;
  CHECK_THAT(ended(folder, 3, "--cylinder x 2.5 20 --ends periodic --rbc 1 --max-iterations 50").err,
             Contains("--soft lets cells deform"));
  CHECK_THAT(run(folder, "10 10 10 --ends periodic --hematocrit 0.9 --dry-run").err,
             Contains("--soft lets cells deform"));
  const Ran soft = ok(folder, "10 10 10 --ends periodic --hematocrit 0.9 --dry-run --soft");
  CHECK_THAT(soft.out, Contains("cells will be soft") && !Contains("--soft lets"));
}

TEST_CASE("Rigid species keep their shape beside soft cells", "[executable]") {
  const TemporaryFolder folder;
  const Ran ran =
      ok(folder,
         "14 14 14 --ends periodic --rbc 19 --wbc 1 --plt 3 --soft --rigid WBC --rigid PLT --state s.h5");
  CHECK_THAT(ran.out, Contains("WBC: rigid") && Contains("Deformed cells: 19") &&
                          Contains("Certificate: clean, no overlap (23 cells"));
  // Undeformed cells have .pos files, with which HemoCell places them where the state has them.
  CHECK_THAT(ran.out, Contains("Wrote ./WBC.pos") && Contains("RBC.pos is not written"));
  CHECK_FALSE(std::filesystem::exists(folder / "RBC.pos"));
  CHECK_THAT(ok(folder, "check --box 14 14 14 --ends periodic").out,
             Contains("WBC: 1 cells") && Contains("PLT: 3 cells") && Contains("Overlapping pairs: 0"));
}

TEST_CASE("Soft platelets and white cells are packed beside soft red cells", "[executable]") {
  const TemporaryFolder folder;
  CHECK_THAT(ok(folder, "14 14 14 --ends periodic --rbc 19 --wbc 1 --plt 3 --soft --state s.h5").out,
             Contains("Deformed cells: 23") && Contains("Certificate: clean"));
}

TEST_CASE("Fixed cells stay beside soft ones, deformed ones, too", "[executable][long]") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "given");
  writeText(folder / "given" / "RBC.pos", rbcPos("5 5 5 0 0 0\n", 1));
  CHECK_THAT(ok(folder, dense + "--fixed given/RBC.pos --state s.h5").out,
             Contains("Deformed cells: 9") && Contains("Certificate: clean, no overlap (10 cells"));
  const std::string tube = "--cylinder x 2.8 20 --ends periodic --soft ";
  ok(folder, tube + "--rbc 1 --state one.h5");
  CHECK_THAT(ok(folder, tube + "--rbc 2 --fixed one.h5 --state two.h5").out,
             Contains("Deformed cells: 2") && Contains("Certificate: clean"));
}

TEST_CASE("Soft cells begin where those of --start and --blood are", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, dense + "--state s.h5");
  for (const std::string& option : std::vector<std::string>{"--start s.h5", "--blood s.h5"})
    CHECK_THAT(ok(folder, dense + option + " --state u.h5").out,
               Contains("Deformed cells: 10") && Contains("Certificate: clean"));
}

TEST_CASE("Layers without cells are kept by soft cells; what is in regions and layers of a profile is said",
          "[executable][long]") {
  const TemporaryFolder folder;
  const std::string tube = "--cylinder x 4 24 --ends periodic --hematocrit 0.45 --soft --state s.h5 ";
  CHECK_THAT(ok(folder, tube + "--cell-free-layer 0.6").out,
             Contains("Deformed cells:") && Contains("Certificate: clean"));
  ok(folder, "check --cylinder x 4 24 --ends periodic --start s.h5 --cell-free-layer 0.59");
  const std::string wide = "--cylinder x 8 16 --ends periodic --hematocrit 0.45 --soft --state s.h5 ";
  CHECK_THAT(ok(folder, wide + "--profile developed").out,
             Contains("Deformed cells:") && Contains("Profile,"));
  writeText(folder / "config.xml",
            configXml("<dx> 5e-7 </dx> <nx> 48 </nx> <ny> 20 </ny> <nz> 20 </nz>",
                      "<packing><container><cylinder axis=\"x\" radius=\"4\" length=\"24\" center=\"11.75 "
                      "4.75 4.75\"/></container>"
                      "<ends>periodic</ends><hematocrit>0.3</hematocrit><soft>true</soft>"
                      "<region hematocrit=\"0.6\"><box size=\"12 10 10\"/></region></packing>"));
  writeText(folder / "RBC.xml", cellXml("RBC", 3.91, 600, ""));
  writeText(folder / "PLT.xml", cellXml("PLT", 1.25, 66, "<aspectRatio> 0.434782608696 </aspectRatio>"));
  CHECK_THAT(ok(folder, "config.xml --state s.h5").out, Contains("Deformed cells:") &&
                                                            Contains("Hematocrit of region 1:") &&
                                                            Contains("with their centres in it"));
}

TEST_CASE("Forces are proportional to <kBT>, and those of each species are told", "[executable]") {
  SampleCase folder;
  const auto config = [&](const std::string& more) {
    writeText(folder / "config.xml",
              configXml("<dx> 5e-7 </dx><nx> 20 </nx><ny> 20 </ny><nz> 20 </nz>" + more));
  };
  writeText(folder / "PLT.xml", cellXml("PLT", 1.25, 66, "<aspectRatio> 0.434782608696 </aspectRatio>"));
  config("");
  const std::string cells = "config.xml --ends periodic --walls none ";
  ok(folder, cells + "--hematocrit 0.73 --plt_ratio 0.1 --soft --state s.h5 --report r.json");
  const auto deformationIn = [&](const char* name) { return readJson(folder / name)["deformation"]; };
  const auto once = deformationIn("r.json");
  REQUIRE(once["species"].size() == 2);
  CHECK(once["species"][0]["name"] == "RBC");
  CHECK(once["species"][1]["name"] == "PLT");
  double most = 0.0;
  for (const auto& species : once["species"])
    most = std::max(most, species["largest"]["force"].get<double>());
  CHECK(once["largest"]["force"] == most);
  CHECK(most <= 10.0);
  config("<kBT> 8.201062782e-21 </kBT>");
  const std::string check = ok(folder, "check " + cells + "--start s.h5 --report t.json").out;
  const auto twice = deformationIn("t.json");
  for (int s = 0; s < 2; ++s)
    CHECK(twice["species"][s]["largest"]["force"].get<double>() ==
          Approx(2.0 * once["species"][s]["largest"]["force"].get<double>()).epsilon(1e-6));
  CHECK_THAT(check, Contains("; median of cells "));
  const std::string packed =
      cells + "--hematocrit 0.73 --plt_ratio 0.1 --soft --max-iterations 5 --state u.h5";
  CHECK_THAT(run(folder, packed).out, Contains("kBT 8.201062782e-21 J (config.xml:4: <kBT>)"));
  config("");
  requireRefused(folder, {{packed + " --restart u.checkpoint.h5", 2,
                           "have other membranes: the constants of their XML files, <kBT>"}});
}
