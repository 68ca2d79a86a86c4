// SPDX-License-Identifier: AGPL-3.0-or-later
// Problems that are made of requests.
#include "hemocell_adapter/problem/make_problem.h"

#include <numeric>
#include <optional>

#include "hemocell_adapter/problem/depth_profile.h"
#include "hemocell_adapter/problem/parts.h"
#include "hemocell_adapter/session/session.h"
#include "packMesh/core/error.h"
#include "packMesh/packing/pack.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

namespace {

const std::vector<std::string> tube = {"--cylinder", "x",        "12.5",        "40",
                                       "--ends",     "periodic", "--plt_ratio", "0"};

std::vector<std::string> inTube(const std::vector<std::string>& words) {
  std::vector<std::string> all = tube;
  all.insert(all.end(), words.begin(), words.end());
  return all;
}

}  // namespace

TEST_CASE("The hematocrit of a lumen stands beside the request, which is as it was", "[make]") {
  CHECK(planned(inTube({"--hematocrit", "0.3"})).hematocrit == 0.3);
  CHECK_FALSE(planned(inTube({"--rbc", "9"})).hematocrit);
  const CompletedRequest completed =
      requestToPack(parseCommandLine("packMesh", inTube({"--discharge-hematocrit", "0.3"})).request);
  const Problem problem = problemToPack(completed);
  CHECK(problem.hematocrit == Approx(tubeHematocrit(0.3, 25.0)).epsilon(1e-6));
  CHECK(problem.request.hematocrit == completed.request.hematocrit);
  CHECK(double(problem.species[0].count) * problem.species[0].shape->volume() ==
        Approx(*problem.hematocrit * problem.lumen.container->volume()).margin(50.0));
}

TEST_CASE("The rest beside regions has the hematocrit that follows from a discharge hematocrit", "[make]") {
  const SampleCase folder(
      "<packing> <ends> periodic </ends> <dischargeHematocrit> 0.3 </dischargeHematocrit> "
      "<species name=\"RBC\"/> <region hematocrit=\"0.1\"> <box origin=\"0 0 0\" size=\"12 30 30\"/> "
      "</region> </packing>");
  const Problem problem = planned({(folder / "config.xml").string()});
  REQUIRE(problem.layout.regions.size() == 2);
  CHECK(problem.layout.regions.front().hematocrit == 0.1);
  CHECK(problem.layout.regions.back().hematocrit == problem.hematocrit);
  CHECK(*problem.hematocrit < 0.28);
}

TEST_CASE("What is packed needs no problem: unmoved cells are written as they were read", "[make]") {
  const TemporaryFolder folder;
  const std::string file = folder.write("RBC.pos", "1\n10 10 10 390 0.1 -720\n");
  std::optional<PackingProblem> packing;
  Pose pose;
  Placement expected;
  {
    const Problem problem = planned({"20", "20", "20", "--fixed", file, "--plt", "1"});
    REQUIRE(problem.species[0].fixed.size() == 1);
    pose = poseOf(problem.species[0].fixed[0]);
    expected = placementOf(problem.species[0].fixed[0]);
    packing = packingProblemOf(problem, problem.atDemanded);
  }
  CHECK(packing->physics.placement(pose).linear == expected.linear);
  CHECK(packing->physics.placement(pose).translation == expected.translation);
}

TEST_CASE("A problem is made for a check without numbers, and knows what it cannot examine", "[make]") {
  const TemporaryFolder folder;
  folder.write("RBC.pos", "1\n10 10 10 0 0 0\n");
  folder.write("Own.pos", "1\n10 10 10 0 0 0\n");
  Request asked;
  asked.boxSize = Vec3(20, 20, 20);
  const Problem problem = problemToCheck(requestToCheck(asked), folder.path());
  REQUIRE(problem.species.size() == 1);
  CHECK(problem.species[0].name == "RBC");
  CHECK(problem.species[0].count == 0);
  CHECK(problem.unchecked == std::vector<std::string>{"Own.pos"});
  CHECK(problem.posFolder == folder.path());
  CHECK(problem.atDemanded.parts.empty());
  REQUIRE_FALSE(problem.notices.warnings.empty());
  CHECK_THAT(problem.notices.warnings.back(), Contains("Own.pos is not checked"));
}

TEST_CASE("Parts have all cells of a problem, and other clearances other walls", "[make]") {
  const Problem problem = planned(inTube({"--hematocrit", "0.2"}));
  const auto cellsIn = [](const PartsToPack& packed) {
    return std::accumulate(packed.parts.begin(), packed.parts.end(), std::int64_t(0),
                           [](std::int64_t sum, const Part& part) { return sum + part.cells.count; });
  };
  const PartsToPack wide = partsAt(problem, problem.layout, {0.1, 0.5});
  CHECK(cellsIn(problem.atDemanded) == problem.mostCells());
  CHECK(cellsIn(wide) == problem.mostCells());
  CHECK(wide.clearances.wall == 0.5);
  CHECK(problem.atDemanded.clearances.wall == 0.0);
}

TEST_CASE("A box that is repeated is a problem of its own, with all cells where they are", "[make]") {
  const Problem problem =
      planned({"12", "12", "12", "--rbc", "3", "--ends", "periodic", "--tile", "2", "1", "1"});
  PackingResult packed = pack(packingProblemOf(problem, problem.atDemanded));
  REQUIRE(packed.outcome == Outcome::certified);
  nameBySpecies(problem.atDemanded, packed);
  const Problem big = tiledProblem(problem, problem.atDemanded.clearances, packed);
  CHECK(*big.request.boxSize == Vec3(24, 12, 12));
  CHECK(problem.request.isTiled());
  CHECK_FALSE(big.request.isTiled());
  REQUIRE(big.species[0].start.size() == 6);
  CHECK(big.species[0].count == 6);
  CHECK((big.species[0].start[1].position - big.species[0].start[0].position - Vec3(12, 0, 0)).norm() <
        1e-12);  // images follow each other
}

TEST_CASE("A problem with other cells has these, and asks for what it asked for", "[make]") {
  const Problem problem = planned(inTube({"--hematocrit", "0.1", "--wall-clearance", "0.2"}));
  std::vector<SpeciesPlan> plans(problem.species.begin(), problem.species.end());
  plans[0].start = {PosLine{{10, 0, 0}, {90, 0, 0}}, PosLine{{20, 0, 0}, {90, 0, 0}}};
  plans[0].start[1].vertices = scaledBy(1.1, problem.species[0].shape->mesh().vertices);
  plans[0].ownTriangles = problem.species[0].shape->mesh().triangles;
  const Problem made = withOtherCells(problem, plans, {0.05, 0.3});
  CHECK(made.species[0].count == 2);
  CHECK(made.request.hematocrit == 0.1);
  CHECK(made.hematocrit == 0.1);
  CHECK(made.lumen.container == problem.lumen.container);
  CHECK(made.demanded.wall == 0.3);
  CHECK(made.atDemanded.clearances.membranes == 0.05);
  REQUIRE(made.atDemanded.parts.size() == 1);
  CHECK(made.atDemanded.parts[0].cells.placed() == 2);
  CHECK(made.hasDeformed());
  const double volume = problem.species[0].shape->volume();
  CHECK(made.species[0].meanVolume == Approx(0.5 * (1.0 + 1.331) * volume));
  CHECK(problem.species[0].count > 2);
}
