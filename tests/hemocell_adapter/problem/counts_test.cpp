// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/counts.h"

#include <cmath>

#include "packMesh/core/error.h"
#include "tests/support/catch.h"

using namespace packmesh::hemocell;

namespace {

CellSpecies species(const std::string& name, double volume, bool red) {
  CellSpecies s;
  s.name = name;
  s.countedVolume = volume;
  s.sharesHematocrit = red;
  return s;
}

}  // namespace

TEST_CASE("A hematocrit is met to within half a cell", "[counts]") {
  for (const double hematocrit : {0.01, 0.3, 0.4, 0.45, 0.5}) {
    CellSpecies platelets = species("PLT", 3.25, false);
    platelets.ratio = 0.07;
    const auto n = numbersOfCells({species("RBC", 81.116, true), platelets}, hematocrit, 25000.0);
    CHECK(std::abs(double(n[0]) * 81.116 - hematocrit * 25000.0) <= 0.5 * 81.116 + 1e-9);
    CHECK(n[1] == std::llround(0.07 * double(n[0])));
  }
}

TEST_CASE("Cell numbers agree with packCells", "[counts]") {
  struct Row {
    double volume, hematocrit;
    std::int64_t rbc, plt;
  };
  for (const Row& row : {Row{125000, 0.3, 387, 27},
                         {51 * 26 * 26, 0.3, 107, 7},
                         {125000, 0.45, 580, 41},
                         {27000, 0.2, 56, 4}}) {
    CellSpecies platelets = species("PLT", 3.25, false);
    platelets.ratio = 0.07;
    const auto n = numbersOfCells({species("RBC", 97, true), platelets}, row.hematocrit, row.volume);
    CHECK(n[0] == row.rbc);
    CHECK(n[1] == row.plt);
  }
}

TEST_CASE("Several red species share the hematocrit", "[counts]") {
  CellSpecies stiff = species("RBC_stiff", 80, true);
  stiff.ratio = 0.25;
  CellSpecies fixed = species("vRBC", 120, true);
  fixed.statedCount = 10;
  const auto n = numbersOfCells({species("RBC", 80, true), stiff, fixed}, 0.4, 100000.0);
  CHECK(n[2] == 10);
  CHECK(n[1] == std::llround(0.25 * double(n[0] + n[1] + n[2])));
  const double volume = 80.0 * double(n[0] + n[1]) + 120.0 * double(n[2]);
  CHECK(std::abs(volume - 40000.0) <= 40.0);
}

TEST_CASE("A ratio refers to all red cells, however their numbers are determined", "[counts]") {
  CellSpecies platelets = species("PLT", 3.25, false), stiff = species("RBC_stiff", 81.1, true),
              infected = species("iRBC", 81.1, true), normal = species("RBC", 81.1, true);
  platelets.ratio = 0.07;
  stiff.ratio = 0.25;
  infected.ratio = 0.01;
  // 40,000 µm³ of red cells are 493: a quarter is stiff, a hundredth infected, 35 platelets.
  auto n = numbersOfCells({platelets, normal, stiff, infected}, 0.4, 100000.0);
  CHECK(n == std::vector<std::int64_t>{35, 365, 123, 5});
  // Without a hematocrit 74 normal ones are the other 0.74.
  normal.statedCount = 74;
  n = numbersOfCells({platelets, stiff, normal, infected}, {}, 100000.0);
  CHECK(n == std::vector<std::int64_t>{7, 25, 74, 1});
  stiff.ratio = 0.995;
  CHECK_THROWS_WITH(numbersOfCells({stiff, normal, infected}, {}, 1000.0),
                    Contains("add up to 1.005") && Contains("share of all red cells"));
}

TEST_CASE("Requests without meaning are rejected", "[counts]") {
  CHECK_THROWS_WITH(numbersOfCells({species("RBC", 81, true)}, 0.001, 1000.0), Contains("nothing to pack"));
  CellSpecies none = species("RBC", 81, true);
  none.statedCount = 0;
  CHECK_THROWS_WITH(numbersOfCells({none}, {}, 1000.0), Contains("every count is 0"));
  CHECK_THROWS_WITH(numbersOfCells({species("RBC", 81, true), species("vRBC", 81, true)}, 0.3, 1000.0),
                    Contains("cannot determine both 'RBC' and 'vRBC'"));
  CellSpecies many = species("vRBC", 120, true);
  many.statedCount = 100;
  CHECK_THROWS_WITH(numbersOfCells({species("RBC", 81, true), many}, 0.3, 1000.0),
                    Contains("exceed the hematocrit"));
  CHECK_THROWS_WITH(numbersOfCells({species("RBC", 1e-3, true)}, 0.5, 1e12), Contains("too many"));
}
