// SPDX-License-Identifier: AGPL-3.0-or-later
// Files of cells for other programs, with the real executable.
#include <algorithm>
#include <catch2/catch.hpp>
#include <iterator>

#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/exports.h"
#include "tests/hemocell_adapter/sample_case.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
using Catch::Matchers::Contains;

TEST_CASE("Exports contain the cells of the .pos files", "[executable]") {
  const TemporaryFolder folder;
  // A format that is asked for twice is written once.
  ok(folder,
     "16 16 16 --ends periodic --rbc 5 --plt 3 --export csv --export csv --export lammps --export mirheo");
  const auto red = readPos(folder.path() / "RBC.pos"), platelets = readPos(folder.path() / "PLT.pos");
  std::istringstream rows(readText(folder.path() / "cells.csv"));
  std::string row;
  std::getline(rows, row);
  std::size_t n = 0;
  while (std::getline(rows, row)) {
    std::replace(row.begin(), row.end(), ',', ' ');
    std::istringstream in(row);
    std::size_t id = 0;
    std::string species;
    double x, y, z, w, a, b, c;
    in >> id >> species >> x >> y >> z >> w >> a >> b >> c;
    REQUIRE(in);
    CHECK(id == ++n);
    const PosLine& line = n <= red.size() ? red[n - 1] : platelets[n - 1 - red.size()];
    CHECK(species == (n <= red.size() ? "RBC" : "PLT"));
    CHECK(Vec3(x, y, z) == line.position);
    CHECK((Quaternion(w, a, b, c).toRotationMatrix() - placementOf(line).linear).cwiseAbs().maxCoeff() <
          1e-12);
  }
  CHECK(n == 8);
  std::istringstream numbers(readText(folder.path() / "RBC.com_q.txt"));
  std::vector<double> all{std::istream_iterator<double>(numbers), {}};
  REQUIRE(all.size() == 7 * red.size());
  CHECK(all[7] == red[1].position.x());
  const std::string data = readText(folder.path() / "cells.lammps");
  CHECK_THAT(data, Contains("8 atoms\n8 ellipsoids\n2 atom types\n") && Contains("0 16 xlo xhi") &&
                       Contains("Atoms # ellipsoid\n\n1 1 1 1 ") && Contains("\nEllipsoids\n\n1 7.8"));
}
