// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/case_source.h"

#include <catch2/catch.hpp>

#include "tests/hemocell_adapter/executable.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

CaseSource scanned(const std::string& text) {
  CaseSource source;
  scanSource(text, "case.cpp", source);
  return source;
}

/// "RBC 1, ? 0.5": cells and distances of the calls in `text`.
std::string distancesIn(const std::string& text) {
  std::ostringstream out;
  for (const DistanceCall& call : scanned(text).distances) {
    out << (out.tellp() > 0 ? ", " : "") << call.name.value_or("?") << ' ';
    if (call.distance)
      out << *call.distance;
    else
      out << '?';
  }
  return out.str();
}

/// "Xpos last - 1, ? ?": directions and slices of the calls in `text`.
std::string inletsIn(const std::string& text) {
  std::string out;
  for (const PreInletCall& call : scanned("int main() {\n" + text + "\n}\n").preInlets)
    out += (out.empty() ? "" : ", ") + call.direction.value_or("?") + " " +
           (call.slice ? toString(*call.slice) : "?");
  return out;
}

}  // namespace

TEST_CASE("Calls of setInitialMinimumDistanceFromSolid are found in common notations", "[case_source]") {
  for (
      const auto& [text, expected] : std::vector<std::pair<std::string, std::string>>{
          {R"(hemocell.setInitialMinimumDistanceFromSolid("RBC", 1); //Micrometer! not LU)", "RBC 1"},
          {R"(hemocell->setInitialMinimumDistanceFromSolid ( "RBC" ,0.5f ) ;)", "RBC 0.5"},
          {"hemocell\n  .setInitialMinimumDistanceFromSolid(\n   \"PLT\", // platelets\n   2.\n );", "PLT 2"},
          {R"(x("a;}"); hemocell.setInitialMinimumDistanceFromSolid("RBC", .25);)", "RBC 0.25"},
          {R"(if (a) h.setInitialMinimumDistanceFromSolid("A", 1); else h.setInitialMinimumDistanceFromSolid("B", 2);)",
           "A 1, B 2"},
          {R"(hemocell.setInitialMinimumDistanceFromSolid("WBC_HO", -1e1L);)", "WBC_HO -10"},
          {R"(int n = 1'000; h.setInitialMinimumDistanceFromSolid("A", 1); int m = 1'000;)", "A 1"},
          // No literals.
          {R"(hemocell.setInitialMinimumDistanceFromSolid(name, 1);)", "? 1"},
          {R"(hemocell.setInitialMinimumDistanceFromSolid("RBC", (*cfg)["a"]["b"].read<T>());)", "RBC ?"},
          {R"(hemocell.setInitialMinimumDistanceFromSolid("RBC", 2 * d);)", "RBC ?"},
          {R"(hemocell.setInitialMinimumDistanceFromSolid("RBC", '1');)", "RBC ?"},
          {R"(hemocell.setInitialMinimumDistanceFromSolid(cell('"'), f(1, 2));)", "? ?"},
          // No calls.
          {R"(//hemocell.setInitialMinimumDistanceFromSolid("RBC", 1);)", ""},
          {R"(/* hemocell.setInitialMinimumDistanceFromSolid("RBC", 1); */)", ""},
          {R"(log << "hemocell.setInitialMinimumDistanceFromSolid(\"RBC\", 1);";)", ""},
          {"#error don't\nh.setInitialMinimumDistanceFromSolid(\"A\", 1);", "A 1"},
          {"#ifdef X\nh.setInitialMinimumDistanceFromSolid(\"A\", 1);\n#endif", "A 1"},
          {"class H { void setInitialMinimumDistanceFromSolid(string name, T distance); };", ""},
          {"void H::setInitialMinimumDistanceFromSolid(string name, T distance) { }", ""},
          {R"(h.setInitialMinimumDistanceFromSolid("A", 1)", ""},
          {"/* never closed", ""},
          {"\"never closed", ""},
          {"\"never closed \\", ""},
          {"/", ""},
          {"", ""}}) {
    INFO(text);
    CHECK(distancesIn(text) == expected);
  }
  const CaseSource source =
      scanned("\n/*\n\n*/\n  h.\n  setInitialMinimumDistanceFromSolid(a\n  [1], 1.5) ;");
  REQUIRE(source.distances.size() == 1);
  CHECK(source.distances[0].where == "case.cpp:6");
  CHECK(source.distances[0].text == "setInitialMinimumDistanceFromSolid(a [1], 1.5)");
}

TEST_CASE("Directions of pre-inlets are literals, and the slice is known of autoPreinletFromBoundary",
          "[case_source]") {
  for (const auto& [text, expected] : std::vector<std::pair<std::string, std::string>>{
           {"hemocell.preInlet->autoPreinletFromBoundary(Direction::Xpos);", "Xpos last - 1"},
           {"hemocell.preInlet->autoPreinletFromBoundary(hemo::Direction::Yneg);", "Yneg 1"},
           {"Box3D slice = flagMatrix->getBoundingBox(); slice.x0 = slice.x1; slice.y1 = 42;\n"
            "hemocell.preInlet->preInletFromSlice(Direction::Xpos, slice);",
            "Xpos ?"},
           {"inlet.preInletFromSlice ( Zneg , plb::Box3D(0, 9, 0, 9, 8, 8) );", "Zneg ?"},
           {"preInlet.preInletFromSlice(direction, slice);", "? ?"},
           {"preInlet.autoPreinletFromBoundary(directions[0]);", "? ?"},
           {"// preInlet.autoPreinletFromBoundary(Direction::Xpos);", ""},
           {"} } ) preInlet.autoPreinletFromBoundary(Direction::Xpos", ""}}) {
    INFO(text);
    CHECK(inletsIn(text) == expected);
  }
  CHECK(scanned("void PreInlet::autoPreinletFromBoundary(Direction dir_) { }").preInlets.empty());
}

TEST_CASE("Planes counted from the last one are read", "[case_source]") {
  CHECK(nodePlaneFromString("0") == 0);
  CHECK(nodePlaneFromString("42") == 42);
  CHECK(nodePlaneFromString("last") == -1);
  CHECK(nodePlaneFromString("last - 5") == -6);
  CHECK(nodePlaneFromString("Last-5") == -6);
  for (const char* wrong : {"", "-1", "1.5", "last5", "last - ", "last + 1", "last - -1", "5 - last", "1e9"})
    CHECK_FALSE(nodePlaneFromString(wrong));
  CHECK(toString(NodePlane(-6)) == "last - 5");
  CHECK(planeIn(-6, 100) == 94);
  CHECK(planeIn(3, 100) == 3);
}

TEST_CASE("All C++ files beside config.xml are read", "[case_source]") {
  const TemporaryFolder folder;
  const std::string text = "h.setInitialMinimumDistanceFromSolid(\"RBC\", 1);";
  writeText(folder.path() / "b.cpp", "#include \"a.h\"\r\n h.setSystemPeriodicityLimit(0, 45);" + text);
  writeText(folder.path() / "a.h", text);
  writeText(folder.path() / "c.cpp.bak", text);
  writeText(folder.path() / "d.txt", text);
  writeText(folder.path() / "e.cc", std::string("\0\xff\xfe\"'#if 0\n/*", 13));
  fs::create_directory(folder.path() / "f.cpp");
  fs::create_symlink("nowhere", folder.path() / "g.cpp");
  const CaseSource source = readCaseSource(folder.path());
  CHECK(source.files == std::vector<std::string>{"a.h", "b.cpp", "e.cc"});
  REQUIRE(source.distances.size() == 2);
  CHECK(source.distances[0].where == "a.h:1");
  CHECK(source.distances[1].where == "b.cpp:2");
  REQUIRE(source.periodicity.size() == 1);
  CHECK(source.periodicity[0].axis == 0.0);
  CHECK(source.periodicity[0].limit == 45.0);
  REQUIRE(source.unread.size() == 1);
  CHECK_THAT(source.unread[0], Contains("g.cpp") && Contains("not searched"));
  CHECK(readCaseSource(folder.path() / "nothing").files.empty());
}
