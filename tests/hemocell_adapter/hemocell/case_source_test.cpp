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

/// "Xpos last - 5 [y 0 42]": of the calls in `text`, inside of main().
std::string inletsIn(const std::string& text) {
  std::string out;
  for (const PreInletCall& call : scanned("int main() {\n" + text + "\n}\n").preInlets) {
    out += (out.empty() ? "" : ", ") + call.direction.value_or("?") + " " +
           (call.slice ? toString(*call.slice) : "?");
    for (const NodeRange& range : call.ranges) out += " [" + toString(range) + "]";
  }
  return out;
}

const std::string box = "Box3D slice = flagMatrix->getBoundingBox();\n";
const std::string call = "hemocell.preInlet->preInletFromSlice(Direction::Xpos, slice);\n";

}  // namespace

TEST_CASE("Calls of setInitialMinimumDistanceFromSolid are found in any notation", "[case_source]") {
  for (
      const auto& [text, expected] : std::vector<std::pair<std::string, std::string>>{
          {R"(hemocell.setInitialMinimumDistanceFromSolid("RBC", 1); //Micrometer! not LU)", "RBC 1"},
          {R"(hemocell->setInitialMinimumDistanceFromSolid ( "RBC" ,0.5f ) ;)", "RBC 0.5"},
          {"hemocell\n  .setInitialMinimumDistanceFromSolid(\n   \"PLT\", // platelets\n   2.\n );", "PLT 2"},
          {R"(x("a;}"); hemocell.setInitialMinimumDistanceFromSolid("RBC", .25);)", "RBC 0.25"},
          {R"(if (a) h.setInitialMinimumDistanceFromSolid("A", 1); else h.setInitialMinimumDistanceFromSolid("B", 2);)",
           "A 1, B 2"},
          {R"(hemocell.setInitialMinimumDistanceFromSolid("WBC" "_HO", -1'0e-1L);)", "WBC_HO -1"},
          // No literals.
          {R"(hemocell.setInitialMinimumDistanceFromSolid(name, 1);)", "? 1"},
          {R"(hemocell.setInitialMinimumDistanceFromSolid("RBC", (*cfg)["a"]["b"].read<T>());)", "RBC ?"},
          {R"(hemocell.setInitialMinimumDistanceFromSolid("RBC", 2 * d);)", "RBC ?"},
          {R"(hemocell.setInitialMinimumDistanceFromSolid("RBC", '1');)", "RBC ?"},
          {R"(hemocell.setInitialMinimumDistanceFromSolid(cell('"'), f(1, 2));)", "? ?"},
          // No calls.
          {R"(//hemocell.setInitialMinimumDistanceFromSolid("RBC", 1);)", ""},
          {"// a \\\nhemocell.setInitialMinimumDistanceFromSolid(\"RBC\", 1);", ""},
          {R"(/* hemocell.setInitialMinimumDistanceFromSolid("RBC", 1); */)", ""},
          {R"(log << "hemocell.setInitialMinimumDistanceFromSolid(\"RBC\", 1);";)", ""},
          {"auto t = R\"x(\" h.setInitialMinimumDistanceFromSolid(\"A\", 1); )x\";", ""},
          {"#if 0\nh.setInitialMinimumDistanceFromSolid(\"A\", 1); // don't\n#endif", ""},
          {"#if 0\nh.setInitialMinimumDistanceFromSolid(\"A\", 1);\n#if X\n#else\n#endif\n#else\n"
           "h.setInitialMinimumDistanceFromSolid(\"A\", 2);\n#endif",
           "A 2"},
          {"#define SET h.setInitialMinimumDistanceFromSolid(\"A\", \\\n 1)\nint x;", ""},
          {"#ifdef X\nh.setInitialMinimumDistanceFromSolid(\"A\", 1);\n#endif", "A 1"},
          {"class H { void setInitialMinimumDistanceFromSolid(string name, T distance); };", ""},
          {"void H::setInitialMinimumDistanceFromSolid(string name, T distance) { }", ""},
          {R"(h.setInitialMinimumDistanceFromSolid("A", 1)", ""},
          {"/* never closed", ""},
          {"\"never closed", ""},
          {"R\"never closed", ""},
          {"", ""}}) {
    INFO(text);
    CHECK(distancesIn(text) == expected);
  }
  const CaseSource source = scanned("\n/*\n\n*/\n  h.\n  setInitialMinimumDistanceFromSolid(a [1] , 1.5) ;");
  REQUIRE(source.distances.size() == 1);
  CHECK(source.distances[0].where == "case.cpp:6");
  CHECK(source.distances[0].text == "setInitialMinimumDistanceFromSolid(a[1], 1.5)");
}

TEST_CASE("Slices of pre-inlets are determined if they depend on literals only", "[case_source]") {
  for (const auto& [text, expected] : std::vector<std::pair<std::string, std::string>>{
           {box + "slice.x1 = slice.x1 - 5;\nslice.x0 = slice.x1;\n" + call, "Xpos last - 5"},
           {box + "slice.x0 = slice.x1 - 10; slice.x1 = slice.x0;" + call, "Xpos last - 10"},
           {box + "/* slice.x0 = 3; */ slice.x0 = slice.x1; slice.y1 = 42; " + call, "Xpos last [y 0 42]"},
           {"Box3D slice = hemocell.lattice->getBoundingBox(); slice.x1 = slice.x0 = slice.x0+2; "
            "hemocell.preInlet->preInletFromSlice(Direction::Xneg,slice);",
            "Xneg 2"},
           {"plb::Box3D bb((*hemocell.lattice).getBoundingBox()); plb::Box3D slice(bb.x0, bb.x1, bb.y0 + 1, "
            "20, 7 - 4, 3); hemo::PreInlet& p = *q; p.preInletFromSlice(hemo::Direction::Zpos, slice);",
            "Zpos 3 [y 1 20]"},
           {"auto slice = flagMatrix->getBoundingBox(); slice.z0 += 4; slice.z1 = slice.z0; slice.x1 -= 3;"
            "inlet->preInletFromSlice(Zneg, slice);",
            "Zneg 4 [x 0 last - 3]"},
           {"preInlet.preInletFromSlice(Direction::Ypos, Box3D(0, 9, 8, 8, 0, 9));",
            "Ypos 8 [x 0 9] [z 0 9]"},
           {"hemocell.preInlet->autoPreinletFromBoundary(Direction::Xpos);", "Xpos last - 1"},
           {"hemocell.preInlet->autoPreinletFromBoundary(Direction::Yneg);", "Yneg 1"},
           {box + "slice.x0 = slice.x1; if (n == 1) { slice.x0 = slice.x1 = 7; " + call + "}", "Xpos 7"},
           {box + "slice.x0 = slice.x1; hlog << \"x0 = \" << slice.x0 << slice.getNx() << endl;" + call,
            "Xpos last"},
           // What the text does not tell.
           {"preInlet.preInletFromSlice(Direction::Xpos, slice);", "Xpos ?"},
           {box + "slice.x0 = slice.x1 = n - 5;" + call, "Xpos ?"},
           {box + "slice.x0 = slice.x1 / 2; slice.x1 = slice.x0;" + call, "Xpos ?"},
           {box + "slice.x0 = slice.y1; slice.x1 = slice.x0;" + call, "Xpos ?"},
           {box + "slice.x0 = slice.x1 + 1; slice.x1 = slice.x0;" + call, "Xpos ?"},
           {box + "slice.x0 = slice.x1; if (wide) slice.y1 = 42;" + call, "Xpos ?"},
           {box + "slice.x0 = slice.x1; if (wide) { slice.y1 = 42; }" + call, "Xpos ?"},
           {box + "slice.x0 = slice.x1; for (int i = 0; i < 3; ++i) { slice.y0 += 1; " + call + "}",
            "Xpos ?"},
           {box + "slice.x0 = slice.x1; narrow(slice);" + call, "Xpos ?"},
           {box + "slice.x0 = slice.x1; ++slice.y0;" + call, "Xpos ?"},
           {box + "slice.x0 = slice.x1; std::cin >> slice.y0;" + call, "Xpos ?"},
           {box + "slice.x0 = slice.x1; slice = slice.enlarge(-1);" + call, "Xpos ?"},
           {box + "slice.x0 = slice.x1; Box3D& other = slice; other.y1 = 2;" + call, "Xpos ?"},
           {"{ " + box + "slice.x0 = slice.x1; } " + call, "Xpos ?"},
           {box + call, "Xpos ?"},  // not flat
           {box + "slice.x0 = slice.x1; preInlet.preInletFromSlice(direction, slice);", "? ?"},
           {"preInlet.autoPreinletFromBoundary(directions[0]);", "? ?"},
           {"// preInlet.autoPreinletFromBoundary(Direction::Xpos);", ""},
           {"} } ) " + box + ") slice.x0 = ;" + call, "Xpos ?"}}) {
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
