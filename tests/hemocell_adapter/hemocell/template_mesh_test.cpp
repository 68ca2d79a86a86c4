// SPDX-License-Identifier: AGPL-3.0-or-later
// Cells of other shapes than HemoCell's own, with the real executable.

#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh::test;

TEST_CASE("User-defined cells are packed", "[executable]") {
  const SampleCase folder;
  ok(folder, "20 20 20 --cell egg 5 3 4 5 --cell-mesh rod 4 tube.stl --mesh-scale rod 3 --vrbc 2 --wbc 1");
  CHECK(cellsIn(folder / "egg.pos") == 5);
  CHECK(cellsIn(folder / "rod.pos") == 4);
  CHECK(run(folder, "check --box 20 20 20 --cell egg 5 3 4 5 --cell-mesh rod 4 tube.stl --mesh-scale rod 3")
            .exitCode == 0);
}

TEST_CASE("A mesh given by --cell-mesh is packed as a case with that STL simulates it", "[executable]") {
  const SampleCase folder;
  writeText(folder / "rod.stl", tubeStl(6, 1, 12));
  std::string xml = cellXml("rod", 3, 600, "<StlFile> rod.stl </StlFile>");
  writeText(folder / "rod.xml", xml);
  writeText(folder / "box.xml", configXml("<dx> 5e-7 </dx> <nx> 32 </nx> <ny> 32 </ny> <nz> 32 </nz>",
                                          "<packing> <walls> none </walls> </packing>"));
  const std::string pack = "16 16 16 --keep-all --cell-mesh rod 60 rod.stl --output-dir box";
  CHECK_THAT(ok(folder, pack).out, Contains("rod.stl, MESH_FROM_STL"));
  CHECK_THAT(ok(folder, "check box.xml --output-dir box").out, Contains("HemoCell keeps 60 of 60 rod"));
  CHECK_THAT(ok(folder, pack + " --mesh-frame rod file").out, Contains("rod.stl, axes of the file"));
  ended(folder, 4, "check box.xml --output-dir box");
  ok(folder, "check box.xml --output-dir box --cell-mesh rod 60 rod.stl --mesh-frame rod file");
  CHECK_THAT(run(folder, "9 9 9 --rbc 1 --mesh-frame RBC file").err, Contains("no mesh file"));
}

TEST_CASE("A mesh or an ellipsoid on the command line replaces that of the file", "[executable]") {
  const SampleCase folder(
      "<packing> <species name=\"egg\" count=\"2\" file=\"tube.stl\" scale=\"4\"/> </packing>");
  CHECK_THAT(run(folder, "config.xml").out, Contains("egg: 2 (2 requested), tube.stl"));
  CHECK_THAT(ok(folder, "config.xml --cell egg 3 4 5 6").out, Contains("egg: 3 (3 requested), ellipsoid"));
}
