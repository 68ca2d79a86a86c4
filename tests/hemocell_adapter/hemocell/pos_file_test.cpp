// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/pos_file.h"

#include <unistd.h>

#include <fstream>
#include <limits>
#include <memory>
#include <random>
#include <sstream>

#include "packMesh/core/error.h"
#include "packMesh/problem/physics.h"
#include "tests/support/catch.h"
#include "tests/support/decimal_comma.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;
using namespace packmesh::hemocell;
namespace fs = std::filesystem;

namespace {

Mat3 rotation(int axis, double degrees) {
  return Quaternion::around(Vec3::Unit(axis), degrees * M_PI / 180.0).toRotationMatrix();
}

}  // namespace

TEST_CASE("A .pos line rotates about x, then y, then z, in degrees", "[pos]") {
  const PosLine line{{1, 2, 3}, {30, 40, 50}};
  const Placement placement = placementOf(line);
  const Mat3 expected = rotation(2, 50) * rotation(1, 40) * rotation(0, 30);
  CHECK((placement.linear - expected).norm() < 1e-15);
  CHECK(placement.translation == Vec3(1, 2, 3));
  CHECK((placementOf({Vec3::Zero(), {0, 0, 90}})(Vec3::UnitX()) - Vec3::UnitY()).norm() < 1e-15);
  CHECK((placementOf({Vec3::Zero(), {0, 90, 0}})(Vec3::UnitZ()) - Vec3::UnitX()).norm() < 1e-15);
  CHECK((placementOf({Vec3::Zero(), {90, 0, 0}})(Vec3::UnitY()) - Vec3::UnitZ()).norm() < 1e-15);
}

TEST_CASE("The example of docs/reference/pos.md is true", "[pos]") {
  const Placement placement = placementOf({{10, 20, 30}, {90, 0, 90}});
  CHECK((placement({1, 2, 3}) - Vec3(13, 21, 32)).norm() < 1e-12);
  CHECK((placement.linear * Vec3::UnitY() - Vec3::UnitZ()).norm() < 1e-12);
}

TEST_CASE("The .pos line of a pose gives the same map as the pose", "[pos]") {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  double worst = 0.0;
  const auto check = [&](const Quaternion& q) {
    const Pose pose{1.0, q, {normal(random), normal(random), normal(random)}};
    const PosLine line = posLineOf(pose);
    REQUIRE(line.position == pose.position);
    REQUIRE(line.angles.cwiseAbs().maxCoeff() <= 180.0);
    REQUIRE(std::abs(line.angles.y()) <= 90.0 + 1e-12);
    worst = std::max(worst, (placementOf(line).linear - q.normalized().toRotationMatrix()).norm());
  };
  for (int i = 0; i < 20000; ++i)
    check(Quaternion(normal(random), normal(random), normal(random), normal(random)));
  // At and near the gimbal lock, from both sides.
  for (double sign : {-1.0, 1.0})
    for (double away : {0.0, 1e-15, 1e-12, 1e-9, 1e-8, 1e-7, 1e-6, 1e-4, 1e-2})
      for (int i = 0; i < 100; ++i)
        check(Quaternion(rotation(2, 360.0 * normal(random)) * rotation(1, sign * (90.0 - away)) *
                         rotation(0, 360.0 * normal(random))));
  for (double a : {-180.0, -90.0, 0.0, 90.0, 180.0})
    for (double b : {-180.0, -90.0, 0.0, 90.0, 180.0})
      for (double c : {-180.0, -90.0, 0.0, 90.0, 180.0})
        check(Quaternion(rotation(2, c) * rotation(1, b) * rotation(0, a)));
  CHECK(worst < 1e-12);
  CHECK(posLineOf({}).angles == Vec3::Zero());
}

TEST_CASE("The .pos line of a cell has its angles, unless they are of another orientation", "[pos]") {
  Cell cell;
  cell.pose = Pose{1.0, Quaternion(rotation(2, 50) * rotation(0, 30)), Vec3(1, 2, 3)};
  CHECK((lineOf(cell).angles - Vec3(30, 0, 50)).norm() < 1e-12);
  cell.angles = Vec3(30, 360, 50);  // in other words
  CHECK(lineOf(cell).angles == cell.angles);
  cell.angles = Vec3(30, 0.01, 50);
  CHECK_THROWS_WITH(lineOf(cell), Contains("the angles of a cell are not those of its orientation"));
}

TEST_CASE("A .pos text is plain, reads back to the last bit and contains no -0", "[pos]") {
  CHECK(formatPosHead(12) == "12\n");
  CHECK(formatPosLines({}) == "");
  CHECK(formatPosLines({{{1.5, -0.0, 3}, {30, -0.0, 1e-5}}}) == "1.5 0 3 30 0 1e-05\n");
  CHECK(formatPosLines({posLineOf({1.0, Quaternion::Identity(), {-0.0, 0.1, 2}})}) == "0 0.1 2 0 0 0\n");
  CHECK_THROWS(formatPosLines({{{1, 2, std::numeric_limits<double>::quiet_NaN()}, Vec3::Zero()}}));

  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-200.0, 200.0);
  std::vector<PosLine> lines(1000);
  for (PosLine& line : lines)
    for (int k = 0; k < 3; ++k) line.position[k] = uniform(random), line.angles[k] = uniform(random);
  auto comma = std::make_unique<test::DecimalComma>();
  const std::string text = formatPosHead(1000) + formatPosLines(lines);
  const test::TemporaryFolder folder;
  const std::vector<PosLine> back = readPos(folder.write("RBC.pos", text));
  comma.reset();
  REQUIRE(back.size() == lines.size());
  bool same = true;
  for (std::size_t i = 0; i < lines.size(); ++i)
    same = same && back[i].position == lines[i].position && back[i].angles == lines[i].angles;
  CHECK(same);
  CHECK(text.find("  ") == text.npos);
  CHECK(text.find(" \n") == text.npos);

  // As HemoCell reads it.
  std::istringstream stream(text);
  int count = 0;
  double numbers[6];
  stream >> count;
  int read = 0;
  while (stream >> numbers[0] >> numbers[1] >> numbers[2] >> numbers[3] >> numbers[4] >> numbers[5]) ++read;
  CHECK(count == 1000);
  CHECK(read == 1000);
}

TEST_CASE("readPos rejects what HemoCell would silently misread, with the line", "[pos]") {
  const test::TemporaryFolder folder;
  const std::string good = "1 2 3 4 5 6\n";
  struct Case {
    std::string text, expected;
  };
  const Case cases[] = {
      {"", ":1: the file is empty"},
      {" \n\n", ":1: the file is empty"},
      {good, ":1: expected the number of cells"},
      {"x y z\n" + good, "found 'x y z'"},
      {"# 1\n" + good, "found '# 1'"},
      {"1.0\n" + good, "found '1.0'"},
      {"-1\n", "found '-1'"},
      {"99999999999999999999\n", "expected the number of cells"},
      {"\xEF\xBB\xBF"
       "1\n" +
           good,
       "byte order mark"},
      {"2\n" + good, ":1: announces 2 cells, but 1 follow: HemoCell would invent the other 1"},
      {"22\n", "RBC.pos:1: has the number of cells, 22, but no cells. packMesh's plug-in writes such files"},
      {"1\n# the first cell\n" + good, ":2: comment"},
      {"2\n" + good + "1 2 3 4 5 6 # fast\n", ":3: 8 fields"},
      {"2\n" + good + "1 2 3 4 5\n", ":3: 5 fields, expected six numbers"},
      {"2\n" + good + "1 2 3 4 5 6 7\n", ":3: 7 fields"},
      {"1\n1 2 3 nan 5 6\n", ":2: field 4 (a): expected a finite number, found 'nan'"},
      {"1\n1 2 inf 4 5 6\n", ":2: field 3 (z): expected a finite number, found 'inf'"},
      {"1\n1e999 2 3 4 5 6\n", ":2: field 1 (x)"},
      {"1\n1,5 2 3 4 5 6\n", "found '1,5'"},
      {"1\n1 2 3 4 5 6;\n", "found '6;'"},
      {"1\n1 2 3 4 5 x\n", ":2: field 6 (c): expected a finite number, found 'x'"},
      {"1\n1 2 3 4 +-5 6\n", "found '+-5'"},
      {std::string("1\n1 2 3 4 5 \0\x01\n", 14), "field 6 (c)"},
  };
  for (const Case& c : cases) {
    CAPTURE(c.text);
    const fs::path file = folder.write("RBC.pos", c.text);
    CHECK_THROWS_WITH(readPos(file), Contains(c.expected) && Contains(file.string()));
  }
  CHECK_THROWS_WITH(readPos(folder.path() / "none.pos"), Contains("none.pos: no such file"));
  CHECK_THROWS_WITH(readPos(folder.path()), Contains("is a folder"));
  CHECK_THROWS_AS(readPos(folder.path() / "none.pos"), InputError);
}

TEST_CASE("readPos accepts what HemoCell reads and warns of what other tools drop", "[pos]") {
  const test::TemporaryFolder folder;
  std::vector<std::string> warnings;
  CHECK(readPos(folder.write("RBC.pos", "0\n"), &warnings).empty());
  CHECK(readPos(folder.write("RBC.pos", "2\n1 2 3 4 5 6\n1 2 3 4 5 -6.5e-1"), &warnings)[1].angles.z() ==
        -0.65);
  CHECK(readPos(folder.write("RBC.pos", "1\n+1 .5 3. 4 5 6\n\n\n"), &warnings)[0].position ==
        Vec3(1, 0.5, 3));
  CHECK(warnings.empty());

  CHECK(
      readPos(folder.write("RBC.pos", "3\n1 2 3 4 5 6\n1\t2 3 4  5 6\n 1 2 3 4 5 6 \n"), &warnings).size() ==
      3);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("RBC.pos:3:") && Contains("pos_to_vtk drops") && Contains("2 lines"));

  warnings.clear();
  CHECK(readPos(folder.write("RBC.pos", "1\r\n1 2 3 4 5 6\r\n"), &warnings)[0].angles == Vec3(4, 5, 6));
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("RBC.pos:1: Windows line ends"));

  warnings.clear();
  CHECK(readPos(folder.write("RBC.pos", "2\n1 2 3 4 5 6\n\n1 2 3 4 5 6\n"), &warnings).size() == 2);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("RBC.pos:3: a blank line"));
}

TEST_CASE("readPos reads the announced number of cells, like HemoCell, and warns of further lines", "[pos]") {
  const test::TemporaryFolder folder;
  std::vector<std::string> warnings;
  const std::string good = "1 2 3 4 5 6\n";
  CHECK(readPos(folder.write("RBC.pos", "1\n" + good + "\n" + good + "not a cell\n"), &warnings).size() == 1);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0],
             Contains("RBC.pos:1: announces 1 cell, but 3 lines follow: HemoCell and packMesh read "
                      "only the first 1"));
  warnings.clear();
  CHECK(readPos(folder.write("RBC.pos", "0\n" + good + good), &warnings).empty());
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("announces 0 cells, but 2 lines follow: HemoCell and packMesh read none"));
}
