// SPDX-License-Identifier: AGPL-3.0-or-later

#include "hemocell_adapter/hemocell/case.h"
#include "packMesh/core/error.h"
#include "tests/hemocell_adapter/executable.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
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
  writeText(folder / "b.cpp", "#include \"a.h\"\r\n h.setSystemPeriodicityLimit(0, 45);" + text);
  writeText(folder / "a.h", text);
  writeText(folder / "c.cpp.bak", text);
  writeText(folder / "d.txt", text);
  writeText(folder / "e.cc", std::string("\0\xff\xfe\"'#if 0\n/*", 13));
  fs::create_directory(folder / "f.cpp");
  fs::create_symlink("nowhere", folder / "g.cpp");
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
  CHECK(readCaseSource(folder / "nothing").files.empty());
}

using namespace packmesh;
using namespace packmesh::test;

namespace {

Case read(const std::string& text) {
  const TemporaryFolder folder;
  writeText(folder / "config.xml", text);
  return readCase(folder / "config.xml");
}

}  // namespace

TEST_CASE("The lattice of a vessel case is read from config.xml", "[case]") {
  const Case config =
      read(configXml("<geometry> <!-- where --> tube.stl </geometry>s <dx> 5e-7 </dx>"
                     "<refDir> 1 </refDir> <refDirN> 50 </refDirN> <unknown/>"));
  CHECK(config.domain.dx == 0.5);
  CHECK(config.domain.geometry->filename() == "tube.stl");
  CHECK(config.domain.refDir == 1);
  CHECK(config.domain.refDirN == 50);
  CHECK_FALSE(config.domain.boxNodes);
}

TEST_CASE("Cases without a geometry are boxes of nodes", "[case]") {
  using Nodes = std::array<int, 3>;
  CHECK(read(configXml("<dx>5e-7</dx><nx> 40 </nx><ny>41</ny><nz>42</nz>")).domain.boxNodes ==
        Nodes{40, 41, 42});
  CHECK(
      read(configXml("<dx>5e-7</dx><Nx>40</Nx><Ny>41</Ny><Nz>42</Nz><refDirN>7</refDirN>")).domain.boxNodes ==
      Nodes{40, 41, 42});
  CHECK(read(configXml("<dx>1e-6</dx><refDirN>256</refDirN>")).domain.boxNodes == Nodes{256, 256, 256});
}

TEST_CASE("The lattice of a case can be that of <container>", "[case]") {
  const std::string nodes =
      "<packing><container><sphere radius='12'/><nodes> 50 50 50 </nodes></container></packing>";
  CHECK_FALSE(read(configXml("<dx>5e-7</dx>", nodes)).domain.boxNodes);
  CHECK_THROWS_WITH(
      read(configXml("<dx>5e-7</dx>", "<packing><container><sphere radius='12'/></container></packing>")),
      Contains("the lattice is unknown. <container><nodes> can give it"));
}

TEST_CASE("<kBT> is read from config.xml, by the plug-in as well", "[case]") {
  const std::string box = "<dx>5e-7</dx><nx>9</nx><ny>9</ny><nz>9</nz>";
  CHECK_FALSE(read(configXml(box)).domain.thermalEnergy);
  const std::string doubled = configXml(box + "<kBT> 8.2e-21 </kBT>");
  CHECK(read(doubled).domain.thermalEnergy == Approx(8.2e-3));
  CHECK_THAT(read(doubled).domain.thermalEnergyWhere, Contains("config.xml:4: <kBT>"));
  CHECK(packingSectionOf(doubled).domain.thermalEnergy == Approx(8.2e-3));
  for (const char* const wrong : {"4e-10", "-1", "0", "nan", "inf", "4.1", "1e-30", "", "4e-21 J"}) {
    CAPTURE(wrong);
    const std::string text = configXml(box + "<kBT> " + wrong + " </kBT>");
    const auto said = Contains("<kBT>: expected a number in [1e-22, 1e-19] [J; 4.1e-21 is that at 297 K]");
    CHECK_THROWS_WITH(read(text), said && Contains("config.xml:4"));
    CHECK_THROWS_WITH(packingSectionOf(text), said);
  }
}

TEST_CASE("The packing section is read from config.xml", "[case]") {
  const Case config = read(configXml(sampleDomain, R"(<packing>
    <!-- all there is -->
    <hematocrit> 0.4 </hematocrit> <hematocritVolume> fluid </hematocritVolume> <redCellVolume> 97 </redCellVolume>
    <seed> 7 </seed> <method> cat </method>
    <clearance> 0.1 </clearance> <wallClearance> 0.2 </wallClearance> <rotate> no </rotate>
    <preInlet> Zneg </preInlet> <preInletSlice> last - 5 </preInletSlice>
    <preInletRange> y 0 42 </preInletRange> <preInletRange>
    X 3 last-7 </preInletRange>
    <ends> periodic </ends> <walls> y z </walls> <maxTime> 60 </maxTime> <maxIterations> 1e4 </maxIterations>
    <bestEffort> true </bestEffort> <outputDirectory> out </outputDirectory> <povScene> true </povScene>
    <species name="RBC" construction="RBC_FROM_SPHERE" minimumDistanceFromSolid="1"/>
    <species name="PLT" ratio="0.07"/> <species name="WBC" count="2" redCell="false"/>
    <growth padding="0.5" barriers="0.5 1" iterations="7" centring="no"/>
    <species name="spare" count="1" stock="3"/> <species name="odd" count="1" file="odd.stl" scale="1e6"/> <species name="egg" count="1" ellipsoid="1 2 3"/>
    <container>
      <box size="50 40 30" origin="1 2 3"/>
      <obstacles>
        <cylinder axis="z" center="20 20 15" radius="5" length="40"/> <sphere center="40 20 15" radius="5"/>
        <mesh file="post.stl" scale="2" offset="0 0 1"/>
      </obstacles>
      <nodes> 100 80 60 </nodes>
    </container>
  </packing>)"));
  const Request& s = config.packing;
  CHECK(s.hematocrit == 0.4);
  CHECK(s.fluidVolume == true);
  CHECK(s.redCellVolume == 97.0);
  CHECK(s.seed == 7u);
  CHECK(s.method == Method::cat);
  CHECK(s.clearance == 0.1);
  CHECK(s.wallClearance == 0.2);
  CHECK(s.rotate == false);
  CHECK(s.periodicEnds == true);
  CHECK(s.walls == std::string("yz"));
  CHECK(s.preInlet == std::string("Zneg"));
  CHECK(s.preInletSlice == -6);
  CHECK(s.preInletRanges == std::vector<NodeRange>{{1, 0, 42}, {0, 3, -8}});
  CHECK(s.maxSeconds == 60.0);
  CHECK(s.maxIterations == 10000);
  CHECK(s.bestEffort == true);
  CHECK(s.output.folder == config.folder / "out");
  REQUIRE(s.species.size() == 6);
  CHECK(s.species[0].construction == Construction::rbcFromSphere);
  CHECK(s.species[0].minimumDistanceFromSolid == 1);
  CHECK(s.species[1].ratio == 0.07);
  CHECK(s.species[2].redCell == false);
  CHECK(s.species[3].stock == 3);
  CHECK(*s.species[4].meshFile == config.folder / "odd.stl");
  CHECK(s.species[5].ellipsoidAxes == Vec3(1, 2, 3));
  REQUIRE(s.states("growth"));
  CHECK(s.cat.growth.padding == 0.5);
  CHECK(s.cat.growth.barriers == std::vector<double>{0.5, 1.0});
  CHECK(s.cat.growth.maxIterations == 7);
  CHECK_FALSE(s.cat.growth.centring);
  REQUIRE(s.container);
  CHECK(s.container->lumen->size == Vec3(50, 40, 30));
  CHECK(s.container->lumen->origin == Vec3(1, 2, 3));
  REQUIRE(s.container->obstacles.size() == 3);
  CHECK(s.container->obstacles[0].axis == 2);
  CHECK(s.container->obstacles[2].scale == 2.0);
  CHECK(s.container->nodes == Vec3(100, 80, 60));
}

TEST_CASE("Every error in config.xml is reported with its position", "[case]") {
  struct Row {
    std::string text, message;
  };
  const auto packing = [](const std::string& inside) {
    return configXml(sampleDomain, "<packing>" + inside + "</packing>");
  };
  const std::string rest = "<refDir>1</refDir><refDirN>50</refDirN>";
  for (const Row& row : {
           Row{"", "is empty or not text"},
           {std::string("\0<hemocell/>", 12), "is empty or not text"},
           {"garbage", "not well-formed XML"},
           {"\x7f\x45\x4c\x46 binary", "not well-formed XML"},
           {"<hemocell><domain></hemocell>", "not closed by its own end tag"},
           {"<case/>", "<case>: expected the root <hemocell>"},
           {"<hemocell/>", "has no <domain>"},
           {configXml(""), "<domain>: has no <dx>"},
           {configXml("<dx> 5e-7m </dx>"),
            "config.xml:4: <dx>: expected a number in (0, 0.0001] [m; 5e-7 is 0.5 µm], found '5e-7m'"},
           {configXml("<dx> 0.5 </dx>"), "found '0.5'"},
           {configXml("<dx></dx>"), "found nothing"},
           {configXml("<dx> nan </dx>"), "found 'nan'"},
           {configXml("<dx>5e-7</dx><dx>5e-7</dx>"), "this tag occurs twice"},
           {configXml("<dx>5e-7</dx>"), "the lattice is unknown"},
           {configXml("<dx>5e-7</dx><geometry/>" + rest), "<geometry>: expected a file, found nothing"},
           {configXml("<dx>5e-7</dx><geometry>a.stl</geometry><refDir>1</refDir>"), "has no <refDirN>"},
           {configXml("<dx>5e-7</dx><geometry>a.stl</geometry><refDir>3</refDir>"),
            "<refDir>: expected a whole number in [0, 2]"},
           {configXml("<dx>5e-7</dx><geometry>a.stl</geometry><refDir>1</refDir><refDirN>fifty</refDirN>"),
            "found 'fifty'"},
           {configXml("<dx>5e-7</dx><geometry>a.stl</geometry><refDir>1</refDir><refDirN>1e3</refDirN>"),
            "<refDirN>: expected a whole number without exponent, found '1e3'"},
           {configXml("<dx>5e-7</dx><nx>10</nx><ny>10</ny>"), "has no <nz>"},
           {configXml("<dx>5e-7</dx><nx>-10</nx><ny>10</ny><nz>10</nz>"), "found '-10'"},
           {packing("<hematokrit>0.4</hematokrit>"),
            "config.xml:6: <hematokrit>: unknown tag in <packing>; did you mean 'hematocrit'?"},
           {packing("<hematocrit>40</hematocrit>"), "<hematocrit>: expected a number in [0, 1)"},
           {packing("<hematocrit>0,4</hematocrit>"), "found '0,4'"},
           {packing("<seed>-1</seed>"), "<seed>: expected a whole number"},
           {packing("<ends>perodic</ends>"), "did you mean 'periodic'?"},
           {packing("<seed>1</seed><seed>2</seed>"), "occurs twice"},
           {packing("seed=1"), "stray text"},
           {packing("<species/>"), "the attribute name is missing"},
           {packing("<species name='RBC' cuont='3'/>"), "unknown attribute 'cuont'; did you mean 'count'?"},
           {packing("<species name='RBC' count='-3'/>"), "attribute count: expected a whole number"},
           {packing("<species name='RBC' construction='RBC_FROM_SPEHRE'/>"),
            "did you mean 'RBC_FROM_SPHERE'?"},
           {packing("<species name='RBC' minimumDistanceFromSolid='-1'/>"), "expected a number in [0, 1000]"},
           {packing("<preInletRange> y 0 </preInletRange>"),
            "<preInletRange>: expected a plane of nodes: 0, 1, ... or last, last-1, ..., found nothing"},
           {packing("<preInletRange> y 0 1 2 </preInletRange>"), "expected 3 values, found 4"},
           {packing("<preInletSlice> -1 </preInletSlice>"), "expected a plane of nodes"},
           {packing("<species name='RBC'/><species name='RBC'/>"), "a second species called 'RBC'"},
           {packing("<species name='RBC'><count>3</count></species>"), "its values are attributes"},
           {packing("<species name='RBC' count='1' ratio='1'/>"), "a count and a ratio"},
           {packing("<container><tube/></container>"), "<tube>: unknown tag"},
           {packing("<container><sphere/></container>"), "the attribute radius is missing"},
           {packing("<container><sphere radius='0'/></container>"),
            "attribute radius: expected a number in (0, 100000]"},
           {packing("<container><sphere radius='1'/><sphere radius='1'/></container>"), "second body"},
           {packing("<container><box size='1 2'/></container>"), "expected three numbers"},
       }) {
    CAPTURE(row.text);
    CHECK_THROWS_AS(read(row.text), InputError);
    CHECK_THROWS_WITH(read(row.text), Contains(row.message));
  }
  CHECK_THROWS_WITH(readCase("no/such/config.xml"), Contains("no such file"));
  CHECK_THROWS_WITH(readCase("/tmp"), Contains("is a folder"));
}

TEST_CASE("The stress that a case expects is read in its file and in a running case", "[case]") {
  const SampleCase folder;
  const auto text = [](const std::string& stress) {
    return configXml(sampleDomain + "<wallShearStress> " + stress + " </wallShearStress>");
  };
  writeText(folder / "config.xml", text("1.5"));
  CHECK(readCase(folder / "config.xml").domain.wallShearStress == 1.5);
  CHECK(packingSectionOf(text("1.5")).domain.wallShearStress == 1.5);
  CHECK_FALSE(packingSectionOf(configXml(sampleDomain)).domain.wallShearStress);
  for (const char* wrong : {"much", "-1"}) {
    writeText(folder / "config.xml", text(wrong));
    CHECK_THROWS_WITH(readCase(folder / "config.xml"), Contains("<wallShearStress>"));
  }
}
