// SPDX-License-Identifier: AGPL-3.0-or-later
// Cases that build obstacles in C++: which nodes are solid.
#include <fmt/format.h>

#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh::test;

TEST_CASE("Nodes in and exactly on obstacles are solid, also where obstacles overlap",
          "[executable][obstacles]") {
  // As StenosisShapeDomain3D and its like say: <= everywhere. Radius 10 nodes: (6, 8), (8, 6) and (10, 0) lie
  // on it.
  const SampleCase folder;
  // A wedge with a slanted face through nodes: i - 4 + j - 4 <= 8, from (4, 4) on.
  writeText(folder / "wedge.off",
            "OFF\n6 8 0\n2 2 -1\n6 2 -1\n2 6 -1\n2 2 21\n6 2 21\n2 6 21\n3 0 2 1\n3 3 4 5\n3 0 1 4\n3 0 4 "
            "3\n3 1 2 5\n"
            "3 1 5 4\n3 2 0 3\n3 2 3 5\n");
  writeText(folder / "config.xml",
            configXml("<dx> 5e-7 </dx> <nx> 40 </nx> <ny> 40 </ny> <nz> 40 </nz>",
                      "<packing> <walls> none </walls> <container> <obstacles>\n"
                      "<cylinder axis=\"z\" radius=\"5\" length=\"30\" center=\"10 10 10\"/>\n"
                      "<box size=\"5 11 22\" origin=\"10 -1 -1\"/>\n"
                      "<sphere radius=\"2.5\" center=\"15 15 10\"/>\n"
                      "<mesh file=\"wedge.off\"/>\n"
                      "</obstacles> </container> </packing>"));
  int fluid = 0;
  for (int k = 0; k < 40; ++k)
    for (int j = 0; j < 40; ++j)
      for (int i = 0; i < 40; ++i) {
        const auto squared = [](int x) { return x * x; };
        const bool solid = squared(i - 20) + squared(j - 20) <= 100 || (i >= 20 && i <= 30 && j <= 20) ||
                           squared(i - 30) + squared(j - 30) + squared(k - 20) <= 25 ||
                           (i >= 4 && j >= 4 && i + j <= 16);
        fluid += !solid;
      }
  const Ran ran = ok(folder, "config.xml --rbc 2 --plt 2");
  CHECK_THAT(ran.out, Contains(fmt::format("({} of 40 x 40 x 40 at dx 0.5 µm)", fluid)));
  CHECK_THAT(ran.out, Contains("4 obstacles") && Contains("HemoCell keeps 4 of 4 cells"));
  ok(folder, "check config.xml");
}
