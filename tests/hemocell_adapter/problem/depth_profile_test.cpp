// SPDX-License-Identifier: AGPL-3.0-or-later
// Hematocrit in a tube and of the blood that leaves it.
#include <cmath>

#include "hemocell_adapter/hemocell/voxel_lumen.h"
#include "hemocell_adapter/problem/depth_profile.h"
#include "packMesh/container/primitives.h"
#include "packMesh/container/vessel.h"
#include "tests/hemocell_adapter/refusal.h"
#include "tests/support/catch.h"
#include "tests/support/walls.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

TEST_CASE("The Fåhraeus relation of Pries et al. 1990 and its inverse", "[profile]") {
  // By hand: D = 50 µm: 0.45 (0.45 + 0.55 (1 + 1.7 e^-20.75 - 0.6 e^-0.55)).
  CHECK(tubeHematocrit(0.45, 50.0) == Approx(0.45 * (0.45 + 0.55 * (1.0 - 0.6 * 0.576950))).epsilon(1e-5));
  CHECK(tubeHematocrit(0.45, 10.0) / 0.45 == Approx(0.7195).epsilon(1e-3));
  CHECK(tubeHematocrit(0.45, 1000.0) == Approx(0.45).epsilon(1e-4));
  CHECK(tubeHematocrit(0.45, 1.0) == 0.45);
  for (const double d : {4.0, 10.0, 20.0, 50.0, 100.0, 300.0})
    for (const double h : {0.05, 0.2, 0.45, 0.7}) {
      CHECK(tubeHematocrit(h, d) <= h);
      CHECK(dischargeHematocrit(tubeHematocrit(h, d), d) == Approx(h));
    }
  CHECK(fahraeusWarning(4.9));
  CHECK(fahraeusWarning(501.0));
  CHECK_FALSE(fahraeusWarning(50.0));
}

TEST_CASE("The cell-free layer explains the Fåhraeus effect", "[profile]") {
  for (const double d : {10.0, 20.0, 40.0, 70.0})
    for (const double h : {0.15, 0.3, 0.45}) {
      const double core = 1.0 - freeLayerOf(h, d) / (0.5 * d);
      CHECK(dischargeHematocrit(h, d) / h == Approx(2.0 - core * core));
    }
  CHECK(freeLayerOf(0.15, 40.0) > freeLayerOf(0.45, 40.0));
  CHECK(freeLayerOf(0.45, 40.0) > freeLayerOf(0.45, 20.0));
  CHECK(freeLayerOf(0.45, 200.0) == freeLayerOf(0.45, 75.0));
}

TEST_CASE("The diameter is that of a cylinder, elsewhere four volumes per area of the wall", "[profile]") {
  const std::array<bool, 3> alongX = {true, false, false}, closed = {};
  for (const bool periodic : {false, true}) {
    CHECK(*hydraulicDiameter(*makeCylinder(Vec3(15, 9, 9), 0, 9.0, 30.0, periodic), alongX) == 18.0);
    const auto vessel =
        makeVessel(sample::straightTube(0.0, 30.0, 9.0, 11, 100), VesselEnds{0, -1.0, 31.0, periodic}, 0.25);
    CHECK(*hydraulicDiameter(*vessel, alongX) == Approx(18.0).epsilon(2e-3));
  }
  CHECK(*hydraulicDiameter(*makeSphere(Vec3(9, 9, 9), 9.0), closed) == Approx(12.0).epsilon(0.01));
  const auto slit = makeBox({Vec3(0, 0, 0), Vec3(20, 30, 10)}, {false, true, false});
  CHECK(*hydraulicDiameter(*slit, {true, true, false}) == Approx(20.0));
  CHECK(*hydraulicDiameter(*slit, {false, true, false}) == Approx(4.0 / (2.0 / 20 + 2.0 / 10)));
  CHECK_FALSE(hydraulicDiameter(*slit, {true, true, true}));
  CHECK_FALSE(hydraulicDiameter(*makeBox({Vec3(0, 0, 0), Vec3(20, 30, 10)}, {true, true, true}), closed));
}

TEST_CASE("The diameter of fluid nodes is that of the vessel without stairs", "[profile][lattice]") {
  for (const double radius : {8.0, 12.5, 20.0})
    for (const bool periodic : {false, true}) {
      const double dx = 0.5;
      const int across = 2 * static_cast<int>(radius / dx) + 3, along = 60;
      const double middle = 0.5 * (across - 1) * dx;
      auto lattice = std::make_shared<Lattice>(std::array<int, 3>{along, across, across}, dx);
      for (int k = 0; k < across; ++k)
        for (int j = 0; j < across; ++j)
          for (int i = 0; i < along; ++i)
            lattice->setFluid(i, j, k, std::hypot(j * dx - middle, k * dx - middle) < radius);
      const auto lumen = makeVoxelLumen(lattice, {periodic, false, false});
      CAPTURE(radius, periodic);
      CHECK(*hydraulicDiameter(*lumen, {true, false, false}) == Approx(2.0 * radius).epsilon(0.03));
    }
}

TEST_CASE("A discharge hematocrit packs the hematocrit of the tube", "[executable][profile]") {
  TemporaryFolder folder;
  const Ran ran = ok(folder, "--cylinder x 12.5 40 --discharge-hematocrit 0.3 --report r.json");
  // 0.3 (0.3 + 0.7 (1 + 1.7 e^-10.375 - 0.6 e^-0.275)) = 0.2043
  CHECK_THAT(ran.out,
             Contains("Discharge hematocrit 0.3: hematocrit 0.2043 in the lumen, 25 µm in diameter"));
  CHECK_THAT(ran.out, Contains("RBC: 49 (by hematocrit)"));
  const auto report = readText(folder / "r.json");
  CHECK_THAT(report, Contains("\"dischargeHematocrit\": 0.3"));
  SampleCase config(
      "<packing> <dischargeHematocrit> 0.2 </dischargeHematocrit> <species name=\"RBC\"/> </packing>");
  CHECK_THAT(ok(config, "config.xml").out, Contains("Discharge hematocrit 0.2: hematocrit 0.1"));
  CHECK_THAT(ok(config, "config.xml --hematocrit 0.1").out,
             Contains("Requested hematocrit: 0.1 of the lumen"));
  const Ran narrow =
      ended(folder, 3, "--cylinder x 2.4 20 --discharge-hematocrit 0.3 --dry-run");  // no red cell fits
  CHECK_THAT(narrow.all(), Contains("outside of the 5 to 500 µm"));
}

TEST_CASE("A discharge hematocrit that means nothing is refused", "[profile]") {
  TemporaryFolder folder;
  requireRefused(folder,
                 {{"--cylinder x 10 30 --discharge-hematocrit 0.3 --hematocrit 0.3", 1, "exclude each other"},
                  {"30 30 30 --ends periodic --discharge-hematocrit 0.3", 2, "this one has none"},
                  {"--cylinder x 10 30 --discharge-hematocrit 1.3", 1, "'--discharge-hematocrit'"},
                  {"--cylinder x 10 30 --discharge-hematocrit 0.3 --rbc 5 --plt 3", 1, ""}});
  SampleCase both(
      "<packing> <hematocrit> 0.2 </hematocrit> <dischargeHematocrit> 0.2 </dischargeHematocrit> </packing>");
  CHECK_THAT(run(both, "config.xml").err, Contains("<hematocrit> and <dischargeHematocrit>"));
}
