// SPDX-License-Identifier: AGPL-3.0-or-later
// Cases whose STL does not end in planes across x: HemoCell fills them, and so does packMesh.
#include <cmath>

#include "hemocell_adapter/settings/request.h"
#include "tests/hemocell_adapter/refusal.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::test;
using packmesh::hemocell::hasCat;
namespace fs = std::filesystem;

namespace {

/// A tube of this radius around points of a curve, with ends across it or, at both, leaning by `slope`.
TriangleMesh tubeAround(const std::vector<Vec3>& curve, double radius, double slope = 0.0) {
  std::vector<std::vector<Vec3>> rings;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Vec3 along = (curve[std::min(i + 1, curve.size() - 1)] - curve[i == 0 ? 0 : i - 1]).normalized();
    const Vec3 u = along.cross(Vec3::UnitZ()).normalized(), v = along.cross(u);
    std::vector<Vec3> ring;
    constexpr int sides = 24;
    for (int k = 0; k < sides; ++k) {
      const double angle = 2.0 * M_PI * k / sides, y = radius * std::cos(angle), z = radius * std::sin(angle);
      ring.push_back(curve[i] + y * u + z * v + slope * y * along);
    }
    rings.push_back(ring);
  }
  return sample::sweep(rings);
}

TriangleMesh oblique() {
  return tubeAround({{0, 0, 0}, {24, 0, 0}}, 6, 0.4);
}

/// A quarter of a ring: one end across x, the other across y.
TriangleMesh bend() {
  std::vector<Vec3> curve;
  for (int i = 0; i <= 16; ++i) {
    const double angle = 0.5 * M_PI * i / 16;
    curve.emplace_back(16 * std::sin(angle), -16 * std::cos(angle), 0.0);
  }
  return tubeAround(curve, 6);
}

TriangleMesh helix() {
  std::vector<Vec3> curve;
  for (int i = 0; i <= 40; ++i) {
    const double angle = 3.0 * M_PI * i / 40;
    curve.emplace_back(30.0 * i / 40, 8 * std::cos(angle), 8 * std::sin(angle));
  }
  return tubeAround(curve, 5);
}

TriangleMesh ring() {
  return sample::torus(Vec3::Zero(), 12, 5, 36, 18);
}

/// A case with this vessel, whose extent along y is so many nodes at dx 0.5 µm as keep its size.
class VesselCase : public SampleCase {
 public:
  explicit VesselCase(const TriangleMesh& mesh, const std::string& packing = "") {
    std::ostringstream stl;
    stl.precision(9);
    stl << "solid v\n";
    for (const Triangle& t : mesh.triangles) {
      stl << "facet normal 0 0 0\nouter loop\n";
      for (const int v : t)
        stl << "vertex " << float(mesh.vertices[v].x()) << ' ' << float(mesh.vertices[v].y()) << ' '
            << float(mesh.vertices[v].z()) << '\n';
      stl << "endloop\nendfacet\n";
    }
    stl << "endsolid v\n";
    writeText(path() / "vessel.stl", stl.str());
    const int nodes = static_cast<int>(std::lround(2 * boundingBox(mesh).size().y()));
    writeText(path() / "config.xml",
              configXml("<geometry> vessel.stl </geometry> <dx> 5e-7 </dx> <refDir> 1 </refDir> <refDirN> " +
                            std::to_string(nodes) + " </refDirN>",
                        packing));
  }
};

}  // namespace

TEST_CASE("Vessels without flat ends perpendicular to x are packed in their fluid nodes",
          "[executable][vessel]") {
  struct Shape {
    const char* name;
    TriangleMesh mesh;
  };
  for (const Shape& shape :
       {Shape{"oblique", oblique()}, {"bend", bend()}, {"helix", helix()}, {"ring", ring()}}) {
    CAPTURE(shape.name);
    const VesselCase folder(shape.mesh);
    const Ran packed =
        ok(folder, "config.xml --hematocrit 0.2 --plt_ratio 0.3 --clearance 0.02 --wall-clearance 0.1");
    CHECK_THAT(packed.out, Contains("fluid nodes in ") && Contains("the hematocrit refers to their volume"));
    const int cells = cellsIn(folder / "RBC.pos") + cellsIn(folder / "PLT.pos");
    CHECK(cells > 3);
    CHECK_THAT(packed.out,
               Contains("HemoCell keeps " + std::to_string(cells) + " of " + std::to_string(cells)));
    CHECK(packed.err.empty());
    CHECK_THAT(ok(folder, "check config.xml --clearance 0.02 --wall-clearance 0.1").out,
               Contains("Cells not wholly inside the lumen, or too near to the wall: 0"));
    // A cell that meets the wall is found.
    writeText(folder / "RBC.pos", "1\n0 0 0 0 0 0\n");
    ended(folder, 4, "check config.xml");
  }
}

TEST_CASE("A lumen of fluid nodes supports layers, regions, fixed cells, periodic ends and growth",
          "[executable][vessel][long]") {
  const VesselCase folder(oblique());
  const Ran layer =
      ok(folder, "config.xml --rbc 3 --plt 2 --cell-free-layer 1.2 --report r.json --vtp --pov");
  ok(folder, "check config.xml --cell-free-layer 1.2");
  CHECK_THAT(readText(folder / "r.json"), Contains("fluid nodes in "));
  CHECK_THAT(run(folder, "config.xml --rbc 3 --plt 2 --dry-run").out, Contains("Feasible"));

  fs::create_directory(folder / "before");
  fs::copy_file(folder / "RBC.pos", folder / "before/RBC.pos");
  ok(folder, "config.xml --rbc 4 --plt 2 --fixed before/RBC.pos");
  ok(folder, "check config.xml");

  ok(folder, std::string("config.xml --rbc 3 --plt 2") + (hasCat() ? " --method cat" : ""));
  ok(folder, "check config.xml");

  const Ran periodic = ok(folder, "config.xml --rbc 6 --plt 2 --ends periodic");
  CHECK_THAT(periodic.out, Contains("periodic along x"));
  ok(folder, "check config.xml --ends periodic");

  const VesselCase regions(
      oblique(),
      "<packing> <hematocrit> 0.05 </hematocrit> <region hematocrit=\"0.2\"> <box size=\"12 20 20\" "
      "origin=\"0 0 0\"/> </region> </packing>");
  CHECK_THAT(ok(regions, "config.xml").out, Contains("Hematocrit of region 1"));
}

TEST_CASE("A lumen of fluid nodes gives the same bytes on any number of ranks",
          "[executable][vessel][long]") {
  std::string files;
  for (const int ranks : {1, 2, 4}) {
    const VesselCase folder(bend());
    REQUIRE(runProcess(folder, "config.xml --hematocrit 0.2 --plt_ratio 0.3 --clearance 0.02", onRanks(ranks))
                .exitCode == 0);
    const std::string here = readText(folder / "RBC.pos") + readText(folder / "PLT.pos");
    if (ranks == 1) files = here;
    CHECK((here == files));
  }
}

TEST_CASE("Surfaces that cross themselves are packed in the nodes that HemoCell makes fluid",
          "[executable][vessel][long]") {
  const auto joined = [](TriangleMesh mesh, const TriangleMesh& other, const Vec3& shift) {
    const int first = int(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const Triangle& t : other.triangles)
      mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    for (Vec3& v : mesh.vertices) v += shift;
    return mesh;
  };
  const TriangleMesh along = tubeAround({{0, 0, 0}, {40, 0, 0}}, 6);
  const Vec3 positive(2.0, 22.0, 8.0);
  struct Shape {
    const char* name;
    TriangleMesh mesh;
  };
  for (const Shape& shape :
       {Shape{"two that cross", joined(along, tubeAround({{20, -20, 0}, {20, 20, 0}}, 5), positive)},
        Shape{"one that begins in the other",
              joined(along, tubeAround({{20, 0, 0}, {20, 20, 0}}, 5), positive)}}) {
    CAPTURE(shape.name);
    const VesselCase folder(shape.mesh);
    for (const std::string lumen : {"config.xml", "--vessel vessel.stl 1"}) {
      CAPTURE(lumen);
      const Ran packed =
          ok(folder, lumen + " --hematocrit 0.15 --plt_ratio 0.1 --clearance 0.02 --wall-clearance 0.1");
      CHECK_THAT(packed.err, Contains("the surface intersects itself: the triangles at (") &&
                                 Contains("the lumen consists of HemoCell's fluid nodes at dx 0.5 µm, "));
      CHECK_THAT(packed.out, Contains("fluid nodes in ") && Contains("Certificate: clean"));
      CHECK(cellsIn(folder / "RBC.pos") > 5);
      ok(folder, "check " + lumen + " --clearance 0.02 --wall-clearance 0.1");
    }
  }
  const VesselCase negative(joined(along, tubeAround({{20, -20, 0}, {20, 20, 0}}, 5), Vec3::Zero()));
  requireRefused(negative,
                 {{"--vessel vessel.stl 1 --hematocrit 0.15", 2,
                   "HemoCell's nodes, which begin at 0, and the surface begins at (0, -20, -6) µm"}});
}
