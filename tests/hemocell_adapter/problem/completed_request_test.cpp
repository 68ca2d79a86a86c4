// SPDX-License-Identifier: AGPL-3.0-or-later

#include "hemocell_adapter/problem/completed_request.h"
#include "hemocell_adapter/problem/species_plans.h"
#include "hemocell_adapter/settings/command_line.h"
#include "tests/hemocell_adapter/refusal.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
namespace fs = std::filesystem;

namespace {

std::string distance(const std::string& arguments) {
  return "  hemocell.setInitialMinimumDistanceFromSolid(" + arguments + "); // Micrometer! not LU\n";
}

std::string code(const std::string& statements) {
  return "#include \"hemocell.h\"\nint main(int argc, char** argv) {\n" + statements + "}\n";
}

/// As the C++ file of a case, "" for none.
void writeCode(const fs::path& folder, const std::string& text) {
  fs::remove(folder / "case.cpp");
  if (!text.empty()) writeText(folder / "case.cpp", text);
}

/// The species of a case with this C++ file, and what is said of them.
struct PlannedSpecies {
  std::vector<SpeciesPlan> plans;
  std::vector<std::string> warnings;
};

PlannedSpecies speciesOf(const std::string& cpp, const std::string& packing = "",
                         std::vector<std::string> options = {"--rbc", "3", "--plt", "1"}) {
  const SampleCase folder(packing);
  writeCode(folder.path(), cpp);
  options.insert(options.begin(), (folder / "config.xml").string());
  const CompletedRequest completed = requestToPack(parseCommandLine("packMesh", options).request);
  PlannedSpecies species{{}, completed.warnings};
  species.plans = plansToPack(completed.request, completed.simulation.get(), species.warnings);
  species.plans = withDistancesFromSolid(*completed.simulation, species.plans, species.warnings);
  return species;
}

/// "RBC 1 case.cpp:3, PLT 0 assumed".
std::string distancesOf(const PlannedSpecies& all) {
  std::string text;
  for (const SpeciesPlan& species : all.plans)
    text += (text.empty() ? "" : ", ") + species.name + " " +
            std::to_string(species.minimumDistanceFromSolid) + " " + species.distanceFromSolidOrigin;
  return text;
}

template <class Any>
std::string warningsOf(const Any& any) {
  std::string text;
  for (const std::string& warning : any.warnings) text += warning + "\n";
  return text;
}

const std::string inletCode = "hemocell.preInlet->autoPreinletFromBoundary(Direction::Xpos);\n";
const std::string sliceCode =
    "slice.x0 = slice.x1;\nhemocell.preInlet->preInletFromSlice(Direction::Xpos, slice);\n";

/// A case with a pre-inlet and this C++ file.
CompletedRequest inletOf(const std::string& cpp, const std::vector<std::string>& options = {}) {
  const SampleCase folder;
  writeText(folder / "config.xml",
            "<hemocell><preInlet><parameters><lengthN> 40 </lengthN></parameters></preInlet><domain>" +
                sampleDomain + "</domain></hemocell>");
  writeCode(folder.path(), cpp.empty() ? "" : code(cpp));
  std::vector<std::string> words = {(folder / "config.xml").string(), "--rbc", "3"};
  words.insert(words.end(), options.begin(), options.end());
  return requestToPack(parseCommandLine("packMesh", words).request);
}

}  // namespace

TEST_CASE("The minimum distance from solid is taken from the case's C++ code", "[job_source]") {
  PlannedSpecies found = speciesOf(code(distance("\"RBC\", 1")));
  CHECK(distancesOf(found) == "RBC 1 case.cpp:3, PLT 0 not set in case.cpp");
  CHECK(warningsOf(found).empty());
  found = speciesOf(code(distance("\"RBC\", 1.9") + distance("\"PLT\", 0.5") + distance("\"WBC\", d")));
  CHECK(distancesOf(found) ==
        "RBC 1 case.cpp:3: 1.9, which HemoCell truncates to whole µm, PLT 0 case.cpp:4: 0.5, which HemoCell "
        "truncates to whole µm");
  CHECK(warningsOf(found).empty());  // of WBC there are none
  found = speciesOf(code(distance("\"RBC\", 1") + distance("\"RBC\", 2.5") + distance("\"RBC\", 1")));
  CHECK(found.plans[0].minimumDistanceFromSolid == 2);
  CHECK_THAT(warningsOf(found), Contains("case.cpp:3 and case.cpp:4 set different") &&
                                    Contains("2.5 µm (2 as HemoCell truncates it), is taken"));
}

TEST_CASE("What cannot be determined from the C++ code gives a warning", "[job_source]") {
  PlannedSpecies found = speciesOf("");
  CHECK(distancesOf(found) == "RBC 0 assumed, PLT 0 assumed");
  REQUIRE(found.warnings.size() == 1);
  CHECK_THAT(found.warnings[0],
             Contains("no C++ file beside config.xml") && Contains("of RBC, PLT is assumed"));
  found =
      speciesOf(code(distance("cell_type, 1") + distance("\"RBC\", cfg[\"d\"]") + distance("\"PLT\", -1")));
  CHECK(distancesOf(found) == "RBC 0 assumed, PLT 0 assumed");
  REQUIRE(found.warnings.size() == 3);
  CHECK_THAT(
      found.warnings[0],
      Contains("case.cpp:3: setInitialMinimumDistanceFromSolid(cell_type, 1): which cell this is for"));
  CHECK_THAT(found.warnings[1], Contains("case.cpp:4: ") && Contains("the distance cannot be determined") &&
                                    Contains("<species name=\"RBC\" minimumDistanceFromSolid="));
  CHECK_THAT(found.warnings[2], Contains("case.cpp:5: ") && Contains("\"PLT\", -1)"));
}

TEST_CASE("A stated minimum distance overrides the C++ code, with a warning if they differ", "[job_source]") {
  const std::string stated =
      "<packing><species name=\"RBC\" count=\"3\" minimumDistanceFromSolid=\"0.5\"/></packing>";
  PlannedSpecies found = speciesOf(code(distance("\"RBC\", 1")), stated, {});
  CHECK(distancesOf(found) == "RBC 0 stated: 0.5, which HemoCell truncates to whole µm");
  REQUIRE(found.warnings.size() == 1);
  CHECK_THAT(found.warnings[0],
             Contains("stated to be 0.5 µm (0 as HemoCell truncates it), but case.cpp:3 says 1 µm:"));
  CHECK_THAT(warningsOf(speciesOf(code(distance("\"RBC\", 1.9")), stated, {})),
             Contains("but case.cpp:3 says 1.9 µm (1 as HemoCell truncates it):"));
  CHECK(warningsOf(speciesOf(code(distance("\"RBC\", 0.3")), stated, {})).empty());
  CHECK(warningsOf(speciesOf("", stated, {})).empty());
  found = speciesOf(code(distance("name, 1")), stated, {"--minimum-distance-from-solid", "RBC", "2"});
  CHECK(distancesOf(found) == "RBC 2 stated");
  CHECK(warningsOf(found).empty());
}

TEST_CASE("The pre-inlet is taken from literals in the case's C++ code", "[job_source][pre_inlet]") {
  CompletedRequest inlet = inletOf(inletCode);
  REQUIRE(inlet.preInlet);
  CHECK(inlet.preInlet->axis == 0);
  CHECK(inlet.preInlet->atHighEnd);
  CHECK(inlet.preInlet->slice == -2);
  CHECK(inlet.preInlet->ranges.empty());
  CHECK(inlet.preInlet->origin == "case.cpp:3");
  // With what is stated.
  inlet = inletOf(inletCode, {"--pre-inlet", "Xpos"});
  CHECK(inlet.preInlet->slice == -2);
  CHECK(inlet.warnings.empty());
  inlet = inletOf(inletCode, {"--pre-inlet-slice", "last - 4", "--pre-inlet-range", "z", "1", "last"});
  CHECK(inlet.preInlet->slice == -5);
  CHECK(inlet.preInlet->ranges == std::vector<NodeRange>{{2, 1, -1}});
  CHECK(inlet.preInlet->origin == "as stated");
  inlet = inletOf(inletCode, {"--pre-inlet", "Xneg"});
  CHECK_FALSE(inlet.preInlet->slice);
  CHECK_THAT(warningsOf(inlet), Contains("stated to be Xneg, but case.cpp:3 says Direction::Xpos"));
  // The direction alone: the slice is stated, or the outermost.
  inlet = inletOf(
      "hemocell.preInlet->preInletFromSlice(Direction::Zpos, place());",
      {"--pre-inlet-slice", "7", "--pre-inlet-range", "y", "2", "last", "--pre-inlet-range", "x", "0", "8"});
  CHECK(inlet.preInlet->axis == 2);
  CHECK(inlet.preInlet->slice == 7);
  CHECK(inlet.preInlet->ranges == std::vector<NodeRange>{{0, 0, 8}, {1, 2, -1}});
  CHECK(inlet.warnings.empty());
  inlet = inletOf(sliceCode, {"--pre-inlet", "Xpos"});
  CHECK_FALSE(inlet.preInlet->slice);
  CHECK_THAT(warningsOf(inlet), Contains("case.cpp:4: preInletFromSlice(Direction::Xpos, slice): slices are "
                                         "not read from the code; the outermost one with fluid is taken"));
}

TEST_CASE("A pre-inlet that cannot be determined is rejected, and the calls are listed",
          "[job_source][pre_inlet]") {
  CHECK_THROWS_WITH(inletOf(""), Contains("is defined in the case's C++ code, of which only") &&
                                     Contains("Find preInletFromSlice"));
  CHECK_THROWS_WITH(inletOf(sliceCode), Contains("case.cpp:4: preInletFromSlice(Direction::Xpos, slice). ") &&
                                            Contains("<preInletSlice>"));
  CHECK_THROWS_WITH(inletOf("hemocell.preInlet->preInletFromSlice(direction, slice);"),
                    Contains("case.cpp:3: preInletFromSlice(direction, slice). "));
  CHECK_THROWS_WITH(inletOf(inletCode + "hemocell.preInlet->autoPreinletFromBoundary(Direction::Zpos);"),
                    Contains("case.cpp:3: ") && Contains("case.cpp:4: "));
  CHECK_THROWS_WITH(inletOf("", {"--pre-inlet-slice", "3"}), Contains("need its direction"));
  CHECK_THROWS_WITH(inletOf("", {"--pre-inlet-slice", "first"}),
                    Contains("a plane of nodes: 0, 1, ... or last"));
  CHECK_THROWS_WITH(inletOf(inletCode, {"--pre-inlet-range", "x", "0", "4"}),
                    Contains("the inlet is along x"));
  CHECK_THROWS_WITH(inletOf(inletCode, {"--pre-inlet-range", "y", "0", "all"}),
                    Contains("pre-inlet-range', hi"));
}

TEST_CASE("A case whose C++ code keeps cells from the wall is packed and checked accordingly",
          "[executable]") {
  const SampleCase folder;
  writeText(folder / "case.cpp", code(distance("\"RBC\", 1")));
  const Ran packed = ok(folder, "config.xml --hematocrit 0.2");
  CHECK(packed.err.empty());
  CHECK_THAT(packed.out, Contains("RBC: minimum distance from solid 1 µm (case.cpp:3)\n") &&
                             Contains("PLT: minimum distance from solid 0 µm (not set in case.cpp)\n"));
  CHECK_THAT(ok(folder, "check config.xml").out,
             Contains("RBC: minimum distance from solid 1 µm (case.cpp:3)\n"));
  // Packed without knowing it, HemoCell deletes cells, and check says so.
  fs::rename(folder / "case.cpp", folder / "case.txt");
  ok(folder, "config.xml --hematocrit 0.3 --wall-clearance 0");
  fs::rename(folder / "case.txt", folder / "case.cpp");
  CHECK_THAT(ended(folder, 4, "check config.xml").out, Contains("closer than 1 µm to a solid node"));
}

TEST_CASE("A request for a cell without a file lists the available cells", "[executable]") {
  const SampleCase folder;
  fs::rename(folder / "RBC.xml", folder / "RBC_HO.xml");
  CHECK_THAT(ended(folder, 2, "config.xml --hematocrit 0.2").err,
             Contains("RBC.xml: no such file") &&
                 Contains("the folder has PLT.xml and RBC_HO.xml. For that") &&
                 Contains("<species name=\"RBC_HO\"/>") && !Contains("config.xml,"));
}

TEST_CASE("A misspelled cell is asked about, but not one that HemoCell has", "[species]") {
  const SampleCase folder("<packing><species name=\"RCB\"/></packing>");
  CHECK_THAT(run(folder, "config.xml --hematocrit 0.2").err,
             Contains("config.xml: how many 'RCB' (did you mean 'RBC'?)? Give it a count or a ratio"));
  const SampleCase counted("<packing><species name=\"RCB\" count=\"2\"/></packing>");
  CHECK_THAT(run(counted, "config.xml").err,
             Contains("RCB.xml: no such file") && Contains("the cell 'RCB' (did you mean 'RBC'?)"));
  CHECK_THAT(run(folder, "config.xml --rbc 2 --wbc 2").err, !Contains("did you mean 'WBC'"));
}

TEST_CASE("Walls and periodic axes of the code that are not read are named", "[code_facts]") {
  const SampleCase folder("<packing> <species name=\"RBC\" count=\"3\"/> </packing>");
  const auto said = [&](const std::string& statements, const std::string& options = "") {
    writeCode(folder.path(), code(statements));
    const Ran ran = ok(folder, "config.xml --dry-run " + options);
    return ran.err;
  };
  const std::string plate =
      "  defineDynamics(*hemocell.lattice, Box3D(0, nx - 1, 0, 0, 0, nz - 1), new BounceBack<T, "
      "DESCRIPTOR>(1.));\n";
  const std::string usual =
      "  defineDynamics(*hemocell.lattice, *flags, hemocell.lattice->getBoundingBox(), new BounceBack<T, "
      "DESCRIPTOR>(1.), 0);\n  hemocell.setSystemPeriodicity(0, true); hemocell.setSystemPeriodicity(1, "
      "false);\n";
  CHECK(said(usual).empty());
  CHECK_THAT(said(usual + plate + plate),
             Contains("case.cpp:5: defineDynamics(") &&
                 Contains("(and 1 more): walls in boxes of nodes are not read") &&
                 Contains("assumed to be that of tube.stl without them") &&
                 Contains("packmesh::loadParticles()"));
  CHECK_THAT(
      said("  hemocell.setSystemPeriodicity(1, true);\n"),
      Contains(
          "case.cpp:3: setSystemPeriodicity(1, true): the lumen is assumed to be that of tube.stl, which "
          "ends along y"));
  CHECK(said("  // hemocell.setSystemPeriodicity(1, true);\n  hemocell.setSystemPeriodicity(axis, false);\n")
            .empty());
  CHECK_THAT(said("  hemocell.setSystemPeriodicity(1, periodic);\n"), Contains("which ends along y"));
  CHECK_THAT(
      said("  hemocell.setSystemPeriodicity(axis, true);\n"),
      Contains("case.cpp:3: setSystemPeriodicity(axis, true): which axis this is cannot be determined") &&
          Contains("assumed to be that of tube.stl") && Contains("packmesh::loadParticles()"));
  writeText(folder / "config.xml", configXml("<dx> 5e-7 </dx> <nx> 40 </nx> <ny> 40 </ny> <nz> 40 </nz>",
                                             "<packing> <species name=\"RBC\" count=\"3\"/> </packing>"));
  const std::string channel = plate + "  hemocell.setSystemPeriodicity(2, true);\n";
  CHECK(said(channel, "--walls y").empty());
  CHECK_THAT(said(channel, "--walls yz"),
             Contains("the box of <domain>, which ends along z") && !Contains("BounceBack"));
}
