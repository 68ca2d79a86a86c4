// SPDX-License-Identifier: AGPL-3.0-or-later
// Against meshes dumped from HemoCell itself. They are not part of the repository; run with
//   PACKMESH_HEMOCELL_GOLDEN=<folder> unit_tests "[golden]"
// The committed tests/data/templates.txt was made from templates that passed this test.
#include <cstdio>
#include <cstdlib>
#include <iostream>

#include "hemocell_adapter/hemocell/cell_model.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

namespace {

double largestDifference(const TriangleMesh& a, const TriangleMesh& b) {
  REQUIRE(a.vertices.size() == b.vertices.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < a.vertices.size(); ++i)
    largest = std::max(largest, (a.vertices[i] - b.vertices[i]).norm());
  return largest;
}

}  // namespace

TEST_CASE("Templates and placed cells equal HemoCell's, vertex by vertex", "[.][golden]") {
  const char* folder = std::getenv("PACKMESH_HEMOCELL_GOLDEN");
  if (!folder) {
    std::cerr
        << "not run: PACKMESH_HEMOCELL_GOLDEN does not name the folder of meshes dumped from HemoCell\n";
    return;
  }
  const std::string path = std::string(folder) + "/";
  for (const std::string name : {"RBC", "PLT", "WBC", "RBC_FROM_STL"}) {
    const CellModel model = readCellXml(path + name + ".xml", name);
    const TriangleMesh mesh = buildTemplate(model, 0.5),
                       golden = readOffText(path + "template_" + name + ".off");
    REQUIRE((mesh.triangles == golden.triangles));
    const double difference = largestDifference(mesh, golden);
    std::printf("template %s: %.3g µm, volume %.6f µm³\n", name.c_str(), difference, signedVolume(mesh));
    CHECK(difference < 1e-6);

    const std::vector<PosLine> lines = readPos(path + name + ".pos");
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const TriangleMesh world = readOffText(path + "placed_" + name + "_" + std::to_string(i) + ".off");
      const double off = largestDifference(placed(mesh, placementOf(lines[i])), world);
      std::printf("placed %s %zu: %.3g µm\n", name.c_str(), i, off);
      CHECK(off < 1e-6);
    }
  }
}
