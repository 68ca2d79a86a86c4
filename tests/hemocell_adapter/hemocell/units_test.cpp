// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/units.h"

#include <random>

#include "packMesh/container/primitives.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
namespace fs = std::filesystem;

TEST_CASE("Spacings that do not resolve cells give a warning with the likely factor", "[units]") {
  for (const double dx : {0.1, 0.25, 0.5, 1.0}) CHECK(!spacingWarning(dx, "x"));
  CHECK_THAT(*spacingWarning(5.0, "c.xml:3: <dx>"),
             Contains("c.xml:3: <dx>: a lattice spacing of 5 µm") && Contains("10 times too large"));
  CHECK_THAT(*spacingWarning(500.0, "x"), Contains("1000 times too large"));
  CHECK_THAT(*spacingWarning(0.0005, "x"), Contains("1000 times too small"));
}

TEST_CASE("The factor of a mesh in another unit is found", "[units]") {
  CHECK(unitHint(50.0, 1.0, smallestVessel, largestVessel).empty());
  CHECK_THAT(unitHint(5e-5, 1.0, smallestVessel, largestVessel), Contains("in m, the factor is 1000000"));
  CHECK_THAT(unitHint(0.05, 1.0, smallestVessel, largestVessel), Contains("in mm, the factor is 1000"));
  CHECK_THAT(unitHint(5e7, 1e6, smallestVessel, largestVessel), Contains("in µm, the factor is 1"));
  CHECK_THAT(unitHint(0.01, 1.0, smallestVessel, largestVessel), Contains("in mm, the factor is 1000"));
  CHECK(unitHint(1e-30, 1.0, smallestVessel, largestVessel).empty());
  CHECK(unitHint(5e-3, 1.0, smallestVessel, largestVessel) ==
        "; if the file is in m, the factor is 1000000, if it is in mm, the factor is 1000, if it is in cm, "
        "the factor is "
        "10000");
}

TEST_CASE("Small cells are not taken for cells in another unit", "[units]") {
  for (const double extent : {1.9, 3.0, 7.8, 15.0})
    CHECK(unitHint(extent, 1.0, smallestCell, largestCell).empty());
  CHECK(unitHint(8e-6, 1.0, smallestCell, largestCell) == "; if the file is in m, the factor is 1000000");
  CHECK(unitHint(8e-3, 1.0, smallestCell, largestCell) == "; if the file is in mm, the factor is 1000");
  CHECK_THAT(unitHint(8e-4, 1.0, smallestCell, largestCell), Contains("in cm, the factor is 10000"));
}

TEST_CASE("Positions in another unit are recognised", "[units]") {
  const auto pipe = makeCylinder({40, 12, 12}, 0, 12, 80, false);
  std::mt19937 random(3);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<>(lo, hi)(random); };
  std::vector<Vec3> positions;
  while (positions.size() < 100) {
    const Vec3 p(uniform(4, 76), uniform(0, 24), uniform(0, 24));
    if (std::hypot(p.y() - 12, p.z() - 12) < 9) positions.push_back(p);
  }
  const auto found = [&](double scale, double dx) {
    std::vector<Vec3> scaled;
    for (const Vec3& p : positions) scaled.push_back(scale * p);
    const auto factor = positionFactor(*pipe, scaled, 8000.0, dx);
    return factor ? factor->factor : 1.0;
  };
  CHECK(found(1.0, 0.5) == 1.0);
  CHECK(found(2.0, 0.5) == 0.5);  // lattice units
  CHECK(found(4.0, 0.25) == 0.25);
  CHECK(found(1e-6, 0.5) == 1e6);
  CHECK(found(1e-3, 0.5) == 1e3);
  CHECK(found(1.5, 0.5) == Approx(2.0 / 3.0));  // made for 0.75 µm
  CHECK(found(0.1, 0.5) == 1.0);                // no unit explains it
  // A box around the pipe in lattice units: a fifth of the cells is in no lumen, whatever the unit.
  const std::vector<Vec3> inPipe = positions;
  positions.clear();
  for (int i = 0; i < 200; ++i) positions.emplace_back(uniform(0, 80), uniform(0, 24), uniform(0, 24));
  CHECK(found(1.0, 0.5) == 1.0);
  CHECK(found(2.0, 0.5) == 0.5);
  CHECK(found(4.0, 0.25) == 0.25);
  positions = inPipe;
  positions.resize(3);
  CHECK(found(2.0, 0.5) == 1.0);  // too few to tell
}

TEST_CASE("Positions of a box around a pipe are not taken for those of another lattice spacing", "[units]") {
  const auto pipe = makeCylinder({25.75, 13, 13}, 0, 12.5, 51.5, false);
  std::mt19937 random(5);
  const auto uniform = [&](double hi) { return std::uniform_real_distribution<>(0, hi)(random); };
  for (const int cells : {5, 7, 20, 107})
    for (int file = 0; file < 300; ++file) {
      std::vector<Vec3> positions;
      for (int i = 0; i < cells; ++i) positions.emplace_back(uniform(51), uniform(26), uniform(26));
      CHECK(!positionFactor(*pipe, positions, 100.0, 0.5));
    }
}

TEST_CASE("The program warns of implausible units", "[executable][units]") {
  const SampleCase folder("<packing> <hematocrit> 0.1 </hematocrit> </packing>");
  SECTION("dx ten times too large") {
    std::string xml = readText(folder / "config.xml");
    xml.replace(xml.find("5e-7"), 4, "5e-6");
    writeText(folder / "config.xml", xml);
    CHECK_THAT(ok(folder, "config.xml --validate").err,
               Contains("config.xml:4: <dx>: a lattice spacing of 5 µm") && Contains("10 times too large"));
    CHECK(run(folder, "40 40 40 --rbc 2 --dx 0.5").err.empty());
    CHECK_THAT(run(folder, "40 40 40 --rbc 2 --dx 5").err,
               Contains("option '--dx': a lattice spacing of 5 µm"));
  }
  SECTION("a vessel in metres or millimetres, and one with another factor") {
    for (const auto& [unit, factor] : {std::pair("0.000001", "1000000"), {"0.001", "1000"}}) {
      const double scale = std::stod(unit);
      writeText(folder / "small.stl", tubeStl(40 * scale, 10 * scale, 24));
      CHECK_THAT(ended(folder, 2, "--vessel small.stl 1 --open-axis x --rbc 5").err,
                 Contains(std::string("the factor is ") + factor));
      CHECK(run(folder, std::string("--vessel small.stl ") + factor + " --open-axis x --rbc 5").err.empty());
    }
    writeText(folder / "rod.stl", tubeStl(6e-6, 1e-6, 12));
    CHECK_THAT(run(folder, "20 20 20 --cell-mesh rod 2 rod.stl").err, Contains("the factor is 1000000"));
    writeText(folder / "rod.stl", tubeStl(3, 0.5, 12));
    CHECK_THAT(run(folder, "20 20 20 --cell-mesh rod 2 rod.stl").err, !Contains("the factor"));
    writeText(folder / "rod.stl", tubeStl(8e-3, 2e-3, 12));
    CHECK_THAT(run(folder, "20 20 20 --cell-mesh rod 2 rod.stl").err, Contains("in mm, the factor is 1000"));
  }
  SECTION("a <container> instead of the <geometry>") {
    writeText(folder / "config.xml",
              configXml(sampleDomain,
                        "<packing> <hematocrit> 0.1 </hematocrit> <container> <cylinder axis=\"x\" "
                        "radius=\"7\" length=\"20\"/> </container> </packing>"));
    CHECK_THAT(run(folder, "config.xml --validate").err,
               Contains("config.xml:6: <cylinder> replaces the <geometry>") && Contains("tube.stl"));
    fs::remove(folder / "tube.stl");
    CHECK_THAT(run(folder, "config.xml --validate").err, !Contains("replaces"));
  }
  SECTION(".pos files in lattice units or metres") {
    ok(folder, "config.xml --hematocrit 0.2 --plt_ratio 1");
    const auto scale = [&](const std::string& name, double factor) {
      std::istringstream in(readText(folder / name));
      std::ostringstream out;
      int count = 0;
      in >> count;
      out << count << '\n';
      for (double x, y, z, a, b, c; in >> x >> y >> z >> a >> b >> c;)
        out << factor * x << ' ' << factor * y << ' ' << factor * z << ' ' << a << ' ' << b << ' ' << c
            << '\n';
      writeText(folder / name, out.str());
    };
    const auto warnings = [&] {
      const Ran ran = ended(folder, 4, "check config.xml");
      return ran.err;
    };
    scale("RBC.pos", 2.0);
    CHECK_THAT(warnings(), Contains("positions of RBC.pos times 0.5 the") && Contains("lattice units") &&
                               !Contains("PLT"));
    scale("PLT.pos", 2.0);
    CHECK_THAT(warnings(), Contains("positions of RBC.pos and PLT.pos times 0.5 the"));
    scale("PLT.pos", 0.5e-6);
    CHECK_THAT(warnings(), Contains("positions of RBC.pos times 0.5 the") &&
                               Contains("positions of PLT.pos times 1e+06 the"));
  }
}
