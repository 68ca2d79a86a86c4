// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/case.h"

#include <catch2/catch.hpp>

#include "packMesh/core/error.h"
#include "tests/hemocell_adapter/sample_case.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
using Catch::Matchers::Contains;

namespace {

Case read(const std::string& text) {
  const TemporaryFolder folder;
  writeText(folder.path() / "config.xml", text);
  return readCase(folder.path() / "config.xml");
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
