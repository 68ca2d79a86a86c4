// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/pre_inlet.h"

#include "hemocell_adapter/base/messages.h"
#include "packMesh/core/error.h"
#include "packMesh/mesh/mesh_file.h"
#include "tests/hemocell_adapter/refusal.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
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

/// Two tubes along x, 15 µm wide and 12.5 µm apart, in one STL.
TriangleMesh twoTubes() {
  TriangleMesh both;
  for (const double y : {0.0, 2.0}) {
    const int first = int(both.vertices.size());
    const TriangleMesh tube = prismAlongX(48, 0.75, 2.4);
    for (const Vec3& v : tube.vertices) both.vertices.push_back(v + Vec3(0, y, 0));
    for (const Triangle& t : tube.triangles)
      both.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return both;
}

VesselOnLattice vessel() {
  const SampleCase folder;
  return placeVessel(readMesh(folder / "tube.stl"), 0.5, 1, 30);
}

}  // namespace

TEST_CASE("A pre-inlet is a slice with a margin of one node and a length of lengthN + 3 planes",
          "[pre_inlet]") {
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

TEST_CASE("A pre-inlet has the fluid nodes of the plane before its slice, in the frame of the slice",
          "[pre_inlet]") {
  // A tube that grows from 7.5 to 15 µm along x: neighbouring planes differ.
  const TemporaryFolder folder;
  writeText(folder / "cone.stl", tubeStl(2.4, 0.75, 48, false, 2.0));
  const VesselOnLattice cone = placeVessel(readMesh(folder / "cone.stl"), 0.5, 1, 60);
  const auto nodesIn = [&](int plane, const std::array<int, 2>& low, const std::array<int, 2>& size) {
    std::int64_t count = 0;
    for (int j = 0; j < size[0]; ++j)
      for (int k = 0; k < size[1]; ++k) count += cone.lattice.fluid(plane, low[0] + j, low[1] + k);
    return count;
  };
  for (const auto& [direction, flags] : {std::pair("Xpos", 23), {"Xneg", 25}}) {
    INFO(direction);
    PreInletPlace place = PreInletPlace::named(direction);
    place.slice = 24;
    const PreInlet inlet = makePreInlet(cone, place, 40);
    CHECK(inlet.flags == flags);
    const auto n = inlet.lattice.nodes();
    const int low = (cone.lattice.nodes()[1] - n[1]) / 2;  // the cone's axis is in the middle
    const std::int64_t here = nodesIn(24, {low, low}, {n[1], n[2]}),
                       there = nodesIn(flags, {low, low}, {n[1], n[2]});
    CHECK(here != there);
    CHECK(inlet.lattice.fluidNodes() == 43 * there);
    // The frame is that of plane 24, a node around its fluid.
    CHECK(nodesIn(24, {low + 1, low + 1}, {n[1] - 2, n[2] - 2}) == here);
    CHECK(nodesIn(24, {low + 2, low + 2}, {n[1] - 4, n[2] - 4}) < here);
    // The true lumen is the section at that plane: 7.5 µm (1 + x / 24 µm) wide, regular with 48 corners.
    const double x = flags * 0.5 - 0.5, radius = 7.5 * (1.0 + x / 24.0);
    CHECK(signedVolume(inlet.surface) ==
          Approx(43 * 0.5 * 24.0 * radius * radius * std::sin(std::acos(-1.0) / 24.0)).epsilon(1e-4));
  }
  PreInletPlace last = PreInletPlace::named("Xneg");
  last.slice = -1;
  CHECK(makePreInlet(cone, last, 40).flags == cone.lattice.nodes()[0] - 1);
}

TEST_CASE("A slice with several outlines requires the choice of one", "[pre_inlet]") {
  const VesselOnLattice tubes = placeVessel(twoTubes(), 0.5, 2, 30);  // axes at y = 16 and 56 nodes
  PreInletPlace place = PreInletPlace::named("Xpos");
  CHECK_THROWS_WITH(makePreInlet(tubes, place, 40), Contains("has 2 outlines: y 1 to 31, z 1 to 31") &&
                                                        Contains("; y 41 to 71, z 1 to 31") &&
                                                        Contains(named("pre-inlet-range") + " y 0 32"));
  place.ranges = {{1, 0, 32}};
  const PreInlet first = makePreInlet(tubes, place, 40);
  CHECK(first.lattice.nodes() == std::array<int, 3>{43, 33, 33});
  CHECK(first.surface.vertices.size() == 192);
  place.ranges = {{1, 36, -1}};
  const PreInlet second = makePreInlet(tubes, place, 40);
  CHECK(second.lattice.nodes() == std::array<int, 3>{43, 33, 33});
  CHECK(second.lattice.fluidNodes() == first.lattice.fluidNodes());
  CHECK(boundingBox(second.surface).lo.y() == Approx(boundingBox(first.surface).lo.y()));
  // Both.
  place.ranges = {{1, 0, -1}};
  CHECK(makePreInlet(tubes, place, 40).lattice.fluidNodes() == 2 * first.lattice.fluidNodes());
  CHECK(makePreInlet(tubes, place, 40).surface.vertices.size() == 384);
  place.ranges = {{1, 34, 38}};
  CHECK_THROWS_WITH(makePreInlet(tubes, place, 40), Contains("has no fluid node in that range"));
  place.ranges = {{1, 30, 20}};
  CHECK_THROWS_WITH(makePreInlet(tubes, place, 40), Contains("y 30 20 is invalid"));
}

TEST_CASE("A slice perpendicular to the vessel has the frame of its own box", "[pre_inlet]") {
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
  // In plane 9, whose fluid nodes it has, the tube is wider than in the frame of plane 8.
  int lowest = 1000;
  for (int k = 0; k < inlet.lattice.nodes()[2]; ++k)
    if (inlet.lattice.fluid(20, 20, k)) lowest = std::min(lowest, k);
  CHECK(lowest == 0);
  CHECK(boundingBox(inlet.surface).lo.z() > -0.25);
  CHECK(boundingBox(inlet.surface).lo.z() <= 0.0);
  place.slice = 0;
  CHECK_THROWS_WITH(makePreInlet(tube, place, 40), Contains("has no fluid node"));
  place.slice = 1000;
  CHECK_THROWS_WITH(makePreInlet(tube, place, 40), Contains("is outside the lattice"));
}

TEST_CASE("A case with a pre-inlet is packed in the frame of the inlet", "[executable]") {
  const PreInletCase folder;
  Ran ran = ok(folder, "config.xml --hematocrit 0.25 --pre-inlet Xpos");
  CHECK_THAT(ran.out, Contains("the pre-inlet: plane") && Contains("of 43 x 33 x 33"));
  ok(folder, "check config.xml --pre-inlet Xpos");
  fs::remove(folder / "RBC.pos");
  fs::remove(folder / "PLT.pos");
  const PreInletCase stated("<packing><hematocrit>0.25</hematocrit><preInlet>Xneg</preInlet></packing>");
  ok(stated, "config.xml");
  requireRefused(folder, {{"config.xml --hematocrit 0.25", 2, "preInletFromSlice(Direction::Xpos, slice)"},
                          {"config.xml --hematocrit 0.25 --pre-inlet-slice 3", 1, "need its direction"},
                          {"config.xml --hematocrit 0.25 --pre-inlet X", 1, "'--pre-inlet'"}});
  // The C++ code alone says it, too, if it has no slice of its own.
  writeText(folder / "case.cpp",
            "int main() {\nhemocell.preInlet->autoPreinletFromBoundary(Direction::Xpos); }");
  ran = ok(folder, "config.xml --hematocrit 0.25 --report r.json");
  CHECK(ran.err.empty());
  CHECK_THAT(ran.out,
             Contains("plane 49 of nodes along x (case.cpp:2), repeated with the fluid nodes of plane 48"));
  CHECK_THAT(readText(folder / "r.json"), Contains("\"preInletSlice\": \"last - 1\""));
  CHECK(run(folder, "check config.xml --pre-inlet-slice 49").err.empty());
  requireRefused({{"config.xml --hematocrit 0.25 --pre-inlet Xpos", 2, "<lengthN>"}});
}
