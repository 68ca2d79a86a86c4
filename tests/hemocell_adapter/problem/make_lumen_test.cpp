// SPDX-License-Identifier: AGPL-3.0-or-later

#include "hemocell_adapter/problem/make_lumen.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

namespace {

/// Said of a box 30 x 20 x 20 with this obstacle on a lattice of 0.5 µm.
std::string saidOf(const std::string& obstacle) {
  const SampleCase folder(
      "<packing><container><box origin=\"0.5 0.5 0.5\" size=\"30 20 20\"/><obstacles>" + obstacle +
      "</obstacles><nodes>63 43 43</nodes></container><species name=\"RBC\" count=\"3\"/></packing>");
  return unseenWallWarning(planned({(folder / "config.xml").string()}).lumen).value_or("");
}

}  // namespace

TEST_CASE("A plate between two planes of nodes is said not to be seen", "[unseen]") {
  // Nodes are at multiples of 0.5 µm.
  const std::string plate = saidOf("<box origin=\"-1 10.1 -1\" size=\"40 0.3 40\"/>");
  CHECK_THAT(plate,
             Contains("a wall is 0.3 µm thick at (") && Contains(", 10.25, ") && Contains("(dx 0.5 µm)"));
  CHECK_THAT(saidOf("<box origin=\"8 10.1 -1\" size=\"9 0.3 40\"/>"), Contains("0.3 µm thick"));
  CHECK(saidOf("<box origin=\"-1 9.9 -1\" size=\"40 0.3 40\"/>").empty());  // a plane of nodes is in it
  CHECK(saidOf("<box origin=\"-1 9.5 -1\" size=\"40 2 40\"/>").empty());
  CHECK(saidOf("<sphere radius=\"4\" center=\"12 10 10\"/>").empty());
  CHECK(saidOf("<cylinder axis=\"z\" radius=\"0.15\" length=\"40\" center=\"12.25 10.25 10\"/>")
            .empty());  // no plate
}

TEST_CASE("The run and the check say it", "[executable][unseen]") {
  const SampleCase folder(
      "<packing><container><box origin=\"0.5 0.5 0.5\" size=\"30 20 20\"/><obstacles>"
      "<box origin=\"-1 10.1 -1\" size=\"40 0.3 40\"/></obstacles><nodes>63 43 43</nodes>"
      "</container><species name=\"RBC\" count=\"3\"/></packing>");
  std::filesystem::remove(folder / "tube.stl");
  CHECK_THAT(ok(folder, "config.xml").err, Contains("HemoCell does not see it"));
  CHECK_THAT(ok(folder, "check config.xml").err, Contains("HemoCell does not see it"));
}

TEST_CASE("A case that changes the size of its vessel says so", "[executable]") {
  const SampleCase folder("<packing><species name=\"RBC\" count=\"1\"/></packing>");
  const auto scale = [&](double length, double radius) {
    writeText(folder / "tube.stl", tubeStl(length, radius, 48));
    return planned({(folder / "config.xml").string()}).lumen.scale;
  };
  CHECK(scale(65.0, 41.0) ==
        "0.1829 µm per unit of tube.stl: <refDirN> 30 makes its y extent 15 µm, which is 82 in the file (if "
        "that is in µm, <refDirN> 164 keeps it)");
  CHECK(scale(24.0, 7.55).empty());  // 30.2 spacings
  for (const double unit : {1e-3, 1e-4, 1e-6}) CHECK(scale(24 * unit, 7.5 * unit).empty());
  scale(2.4, 0.75);
  CHECK_THAT(ok(folder, "config.xml").all(), Contains("Scale: 10 µm per unit of tube.stl: <refDirN> 30"));
  CHECK_THAT(ok(folder, "check config.xml").all(), Contains("Scale: 10 µm per unit"));
}

TEST_CASE("<nodes> gives the lattice, and it is told where <domain> has another one", "[container]") {
  const SampleCase folder;
  const auto lumenOf = [&](const std::string& domain) {
    writeText(
        folder / "config.xml",
        configXml(
            "<dx> 5e-7 </dx>" + domain,
            "<packing><container><sphere radius=\"12\"/><nodes> 50 50 50 </nodes></container></packing>"));
    return planned({(folder / "config.xml").string(), "--rbc", "3"}).lumen;
  };
  for (const char* const domain : {"", "<refDirN> 50 </refDirN>", "<refDirN> 80 </refDirN>"}) {
    CAPTURE(domain);
    const Lumen lumen = lumenOf(domain);
    CHECK(lumen.lattice->nodes() == std::array<int, 3>{50, 50, 50});
    const bool told =
        std::count(lumen.notices.begin(), lumen.notices.end(),
                   "<container><nodes> gives the lattice 50 x 50 x 50 nodes; <domain> has 80 x 80 x 80");
    CHECK(told == (std::string(domain).find("80") != std::string::npos));
  }
}
