// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/pre_inlet.h"

#include <catch2/catch.hpp>

#include "packMesh/error.h"
#include "packMesh/io/mesh_file.h"
#include "sample_case.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

const std::string preInletTag =
    "<preInlet><parameters><lengthN> 40 </lengthN><Re> 0.5 </Re></parameters></preInlet>";

/// The sample case with a pre-inlet.
class PreInletCase : public SampleCase {
 public:
  explicit PreInletCase(const std::string& packing = "") {
    writeText(path() / "config.xml",
              "<hemocell>" + preInletTag + "<domain>" + sampleDomain + "</domain>" + packing + "</hemocell>");
  }
};

VesselOnLattice vessel() {
  const SampleCase folder;
  return placeVessel(readMesh(folder.path() / "tube.stl"), 0.5, 1, 30);
}

}  // namespace

TEST_CASE("a pre-inlet is a slice, with a node around it, lengthN + 3 planes long", "[pre_inlet]") {
  const VesselOnLattice tube = vessel();
  const auto n = tube.lattice.nodes();
  const PreInlet inlet = makePreInlet(tube, PreInletPlace::named("Xpos"), 40);
  CHECK(inlet.slice == n[0] - 1);
  CHECK_FALSE(inlet.reachesBorder);
  CHECK(inlet.lattice.nodes()[0] == 43);
  // Fluid nodes of the tube's cross-section: 1 to n - 2; with the border all of the lattice.
  CHECK(inlet.lattice.nodes()[1] == n[1]);
  std::int64_t inSlice = 0;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j) {
      inSlice += tube.lattice.fluid(n[0] - 1, j, k);
      for (const int i : {0, 20, 42})
        REQUIRE(inlet.lattice.fluid(i, j, k) == tube.lattice.fluid(n[0] - 1, j, k));
    }
  CHECK(inlet.lattice.fluidNodes() == 43 * inSlice);
  // The true lumen: the regular polygon of 48 corners, as long as the lattice.
  CHECK(signedVolume(inlet.surface) ==
        Approx(43 * 0.5 * 24.0 * 7.5 * 7.5 * std::sin(std::acos(-1.0) / 24.0)));
  const Box box = boundingBox(inlet.surface);
  CHECK(box.lo.x() == -0.25);
  CHECK(box.hi.x() == 21.25);
  CHECK(box.center().y() == Approx(0.25 * (n[1] - 1)));
}

TEST_CASE("a slice across the vessel has the frame of its own box", "[pre_inlet]") {
  const VesselOnLattice tube = vessel();
  PreInletPlace place = PreInletPlace::named("yneg");
  CHECK(place.axis == 1);
  CHECK_FALSE(place.atHighEnd);
  place.slice = 8;  // the tube's axis is at y = 16 nodes
  const PreInlet inlet = makePreInlet(tube, place, 40);
  CHECK(inlet.lattice.nodes()[1] == 43);
  CHECK(inlet.lattice.nodes()[0] == tube.lattice.nodes()[0]);
  CHECK(inlet.lattice.nodes()[2] < tube.lattice.nodes()[2]);
  CHECK(inlet.reachesBorder);
  // Fluid begins one node above the low corner.
  int lowest = 1000;
  for (int k = 0; k < inlet.lattice.nodes()[2]; ++k)
    if (inlet.lattice.fluid(20, 20, k)) lowest = std::min(lowest, k);
  CHECK(lowest == 1);
  CHECK(boundingBox(inlet.surface).lo.z() > 0.0);
  CHECK(boundingBox(inlet.surface).lo.z() <= 0.5);
  place.slice = 0;
  CHECK_THROWS_WITH(makePreInlet(tube, place, 40), Contains("has no fluid node"));
  place.slice = 1000;
  CHECK_THROWS_WITH(makePreInlet(tube, place, 40), Contains("is no plane of nodes"));
}

TEST_CASE("a case with a pre-inlet is packed in the inlet's frame", "[executable]") {
  const PreInletCase folder;
  Ran ran = run(folder.path(), "config.xml --hematocrit 0.25 --pre-inlet Xpos");
  INFO(ran.all());
  REQUIRE(ran.exitCode == 0);
  CHECK_THAT(ran.out, Contains("the pre-inlet: plane") && Contains("of 43 x 33 x 33"));
  CHECK(run(folder.path(), "check config.xml --pre-inlet Xpos").exitCode == 0);
  fs::remove(folder.path() / "RBC.pos");
  fs::remove(folder.path() / "PLT.pos");
  const PreInletCase stated("<packing><hematocrit>0.25</hematocrit><preInlet>Xneg</preInlet></packing>");
  CHECK(run(stated.path(), "config.xml").exitCode == 0);
  ran = run(folder.path(), "config.xml --hematocrit 0.25");
  CHECK(ran.exitCode == 2);
  CHECK_THAT(ran.err, Contains("preInletFromSlice(Direction::Xpos, slice)") && Contains("--pre-inlet"));
  ran = run(folder.path(), "config.xml --hematocrit 0.25 --pre-inlet-slice 3");
  CHECK(ran.exitCode == 1);
  CHECK_THAT(ran.err, Contains("needs its direction"));
  CHECK(run(folder.path(), "config.xml --hematocrit 0.25 --pre-inlet X").exitCode == 1);
  const SampleCase without;
  ran = run(without.path(), "config.xml --hematocrit 0.25 --pre-inlet Xpos");
  CHECK(ran.exitCode == 2);
  CHECK_THAT(ran.err, Contains("<lengthN>"));
  CHECK(!fs::exists(without.path() / "RBC.pos"));
}
