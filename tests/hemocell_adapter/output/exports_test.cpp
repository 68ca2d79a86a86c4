// SPDX-License-Identifier: AGPL-3.0-or-later
// Files of cells for other programs, with the real executable: read as those programs do, they give the
// membranes of the .pos files, which do not overlap.
#include <algorithm>
#include <catch2/catch.hpp>
#include <iterator>

#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/hemocell/read_pos.h"
#include "packMesh/container/primitives.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "tests/hemocell_adapter/output/export_readers.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/shapes.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
using Catch::Matchers::Contains;

namespace {

constexpr double exact = 1e-9;            // text with all digits, after rotations [µm]
constexpr double singlePrecision = 1e-5;  // at positions below 60 µm

TriangleMesh centred(const TriangleMesh& mesh) {
  return sample::moved(mesh, -boundingBox(mesh).center());
}

/// No symmetry, and far from the origin of its file.
TriangleMesh oddMesh(unsigned seed) {
  TriangleMesh mesh = bumpyMesh(seed);
  for (Vec3& v : mesh.vertices)
    v = Vec3(0.9 * v.x() + 0.2 * v.y(), 0.5 * v.y(), 0.7 * v.z() + 0.1 * v.x() * v.x());
  return sample::moved(mesh, {3.0, -40.0, 0.5});
}

/// A packing of several species with all formats that take any cells.
struct Packing {
  TemporaryFolder folder;
  std::map<std::string, TriangleMesh> templates;  ///< as HemoCell builds them, or of the files
  std::unique_ptr<Container> container;

  Packing(const std::string& lumen, std::unique_ptr<Container> in) : container(std::move(in)) {
    for (const char* name : {"RBC", "PLT", "WBC"}) templates[name] = hemocellShape(name)->mesh();
    const TriangleMesh odd = oddMesh(3), raw = oddMesh(4);
    templates["Odd"] = meshFromStl(odd, 0.5);
    templates["Raw"] = centred(raw);
    writeMesh(folder.path() / "odd.off", odd);
    writeMesh(folder.path() / "raw.off", raw);
    ok(folder,
       lumen +
           " --rbc 7 --plt 4 --wbc 1 --cell-mesh Odd 4 odd.off --cell-mesh Raw 5 raw.off --mesh-frame Raw "
           "file --export csv --export csv --export lammps --export lammps-molecular --export mirheo "
           "--export espresso --export stl");
  }

  /// HemoCell's membranes of a .pos file.
  Membranes membranes(const std::string& name) const {
    Membranes membranes;
    for (const PosLine& line : readPos(folder.path() / (name + ".pos")))
      membranes.push_back(placed(templates.at(name), placementOf(line)));
    return membranes;
  }

  /// Those of all species, in the order of the program.
  Membranes allMembranes() const {
    Membranes all;
    for (const auto& row : readCsv(folder.path()).membranes) REQUIRE(templates.count(row.first) == 1);
    for (const char* name : {"RBC", "PLT", "WBC", "Odd", "Raw"})
      for (const TriangleMesh& mesh : membranes(name)) all.push_back(mesh);
    return all;
  }
};

/// The same membranes, up to whole periods.
void requireSame(const Membranes& found, const Membranes& expected, const Vec3& period, double tolerance) {
  REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    REQUIRE(found[i].vertices.size() == expected[i].vertices.size());
    Vec3 shift = found[i].vertices[0] - expected[i].vertices[0];
    for (int k = 0; k < 3; ++k)
      shift[k] = period[k] > 0.0 ? period[k] * std::round(shift[k] / period[k]) : 0.0;
    double largest = 0.0;
    for (std::size_t v = 0; v < found[i].vertices.size(); ++v)
      largest = std::max(largest, (found[i].vertices[v] - expected[i].vertices[v] - shift).norm());
    CHECK(largest < tolerance);
    CHECK(found[i].triangles == expected[i].triangles);
  }
}

/// No two membranes meet, in any period, and none meets the wall.
void requireApart(const Membranes& membranes, const Container& container) {
  std::vector<MeshHierarchy> cells;
  for (const TriangleMesh& mesh : membranes) cells.emplace_back(mesh);
  const Vec3 period = container.period();
  const auto most = [&](int k) { return period[k] > 0.0 ? 2 : 0; };  // images in which they were written
  int near = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Sphere own = boundingSphere(cells[i], {});
    if (container.wall()) CHECK(!container.wall()->violation(membranes[i]));
    for (std::size_t j = i; j < cells.size(); ++j)
      for (int x = -most(0); x <= most(0); ++x)
        for (int y = -most(1); y <= most(1); ++y)
          for (int z = -most(2); z <= most(2); ++z) {
            if (i == j && x == 0 && y == 0 && z == 0) continue;
            const Placement image{Mat3::Identity(), period.cwiseProduct(Vec3(x, y, z))};
            const Sphere other = boundingSphere(cells[j], image);
            if ((own.center - other.center).norm() > own.radius + other.radius) continue;
            ++near;
            CHECK(relate(cells[i], {}, cells[j], image).relation == MeshRelation::apart);
          }
  }
  CHECK(near > 0);  // the test is one
}

void requireExports(const Packing& packing) {
  const fs::path folder = packing.folder.path();
  const Vec3 period = packing.container->period();
  const Box bounds = packing.container->bounds();
  const Membranes all = packing.allMembranes();
  requireApart(all, *packing.container);
  const CsvTable table = readCsv(folder);
  CHECK(table.cells == int(all.size()));
  CHECK(table.period == std::vector<double>(period.data(), period.data() + 3));
  CHECK(Vec3(table.box[0], table.box[1], table.box[2]) == bounds.lo);
  CHECK(Vec3(table.box[3], table.box[4], table.box[5]) == bounds.hi);
  Membranes inMirheo, inEspresso;
  for (const auto& [name, mesh] : packing.templates) {
    const Membranes expected = packing.membranes(name);
    REQUIRE(!expected.empty());
    requireSame(table.membranes.at(name), expected, Vec3::Zero(), exact);
    const Membranes mirheo = readMirheo(folder, name, bounds.hi), espresso = readEspresso(folder, name);
    requireSame(mirheo, expected, period, exact);
    requireSame(espresso, expected, Vec3::Zero(), 1e-8);
    inMirheo.insert(inMirheo.end(), mirheo.begin(), mirheo.end());
    inEspresso.insert(inEspresso.end(), espresso.begin(), espresso.end());
  }
  requireApart(inMirheo, *packing.container);
  requireApart(inEspresso, *packing.container);
}

/// The membranes of a molecular data file of LAMMPS, from atoms and angles.
Membranes membranesOf(const LammpsData& data) {
  std::map<int, std::pair<int, int>> place;  // of atoms: molecule, vertex
  Membranes membranes;
  for (const std::vector<double>& atom : data.sections.at("Atoms")) {
    REQUIRE(atom.size() == 6);
    const int molecule = int(atom[1]);
    membranes.resize(std::max<std::size_t>(membranes.size(), molecule));
    std::vector<Vec3>& vertices = membranes[molecule - 1].vertices;
    place[int(atom[0])] = {molecule - 1, int(vertices.size())};
    vertices.emplace_back(atom[3], atom[4], atom[5]);
  }
  for (const std::vector<double>& angle : data.sections.at("Angles")) {
    REQUIRE(angle.size() == 5);
    Triangle triangle;
    for (int k = 0; k < 3; ++k) {
      CHECK(place.at(int(angle[2 + k])).first == place.at(int(angle[2])).first);
      triangle[k] = place.at(int(angle[2 + k])).second;
    }
    membranes[place.at(int(angle[2])).first].triangles.push_back(triangle);
  }
  return membranes;
}

/// Each bond is an edge of a triangle, each dihedral consists of the two triangles at an edge.
void requireTopology(const LammpsData& data) {
  std::map<std::pair<int, int>, int> opposite;  // of a directed edge
  for (const std::vector<double>& angle : data.sections.at("Angles"))
    for (int k = 0; k < 3; ++k)
      opposite[{int(angle[2 + k]), int(angle[2 + (k + 1) % 3])}] = int(angle[2 + (k + 2) % 3]);
  const auto& bonds = data.sections.at("Bonds");
  const auto& dihedrals = data.sections.at("Dihedrals");
  REQUIRE(2 * bonds.size() == opposite.size());  // every edge once
  REQUIRE(dihedrals.size() == bonds.size());
  std::map<std::pair<int, int>, int> seen;
  for (std::size_t i = 0; i < bonds.size(); ++i) {
    const int a = int(bonds[i][2]), b = int(bonds[i][3]);
    CHECK(++seen[std::minmax(a, b)] == 1);
    CHECK(opposite.count({a, b}) == 1);
    const std::vector<double>& d = dihedrals[i];
    CHECK(opposite.at({int(d[3]), int(d[4])}) == int(d[2]));
    CHECK(opposite.at({int(d[4]), int(d[3])}) == int(d[5]));
  }
}

void requireLammps(const Packing& packing, const std::string& boundary) {
  const fs::path folder = packing.folder.path();
  const Membranes all = packing.allMembranes();
  const LammpsData data = readLammps(folder / "cells_molecular.lammps");
  CHECK_THAT(data.title, Contains("types RBC, PLT, WBC, Odd, Raw;") && Contains("boundary " + boundary));
  requireSame(membranesOf(data), all, Vec3::Zero(), exact);
  requireTopology(data);
  for (const auto& [plural, section] : std::map<std::string, std::string>{
           {"atoms", "Atoms"}, {"bonds", "Bonds"}, {"angles", "Angles"}, {"dihedrals", "Dihedrals"}}) {
    CHECK(data.head.at(plural).at(0) == double(data.sections.at(section).size()));
    CHECK(data.head.at(section == "Atoms" ? "atom types" : plural.substr(0, plural.size() - 1) + " types")
              .at(0) == 5);
  }
  CHECK(data.head.at("ylo yhi") == std::vector<double>{0, packing.container->bounds().hi.y()});
  const LammpsData ellipsoids = readLammps(folder / "cells.lammps");
  CHECK(ellipsoids.head.at("ellipsoids").at(0) == double(all.size()));
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::vector<double>&atom = ellipsoids.sections.at("Atoms").at(i),
          &shape = ellipsoids.sections.at("Ellipsoids").at(i);
    REQUIRE(atom.size() == 7);
    REQUIRE(shape.size() == 8);
    // Turned back and moved back, the membrane fits in the box of the ellipsoid.
    TriangleMesh back = sample::moved(all[i], -Vec3(atom[4], atom[5], atom[6]));
    const double inverse[] = {shape[4], -shape[5], -shape[6], -shape[7]};
    back = turned(back, inverse, Vec3::Zero());
    CHECK((2.0 * boundingBox(back).hi - Vec3(shape[1], shape[2], shape[3])).norm() < exact);
    CHECK((2.0 * boundingBox(back).lo + Vec3(shape[1], shape[2], shape[3])).norm() < exact);
  }
}

void requireStl(const Packing& packing) {
  const auto triangles = readBinaryStl(packing.folder.path() / "cells.stl");
  std::size_t next = 0;
  for (const TriangleMesh& mesh : packing.allMembranes())
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t, ++next) {
      REQUIRE(next < triangles.size());
      for (int k = 0; k < 3; ++k)
        if ((triangles[next][k] - mesh.corner(int(t), k)).norm() > singlePrecision) FAIL("triangle " << next);
    }
  CHECK(next == triangles.size());
}

}  // namespace

TEST_CASE("Other programs read the membranes of a periodic box from their exports", "[executable][exports]") {
  const Packing packing("17 18 19 --ends periodic",
                        makeBox({Vec3::Zero(), Vec3(17, 18, 19)}, {true, true, true}));
  requireExports(packing);
  requireLammps(packing, "p p p");
  requireStl(packing);
}

TEST_CASE("Other programs read the membranes of a cylinder from their exports", "[executable][exports]") {
  const Packing packing("--cylinder y 8 24 --ends periodic", makeCylinder({8, 12, 8}, 1, 8, 24, true));
  requireExports(packing);
  requireLammps(packing, "f p f");
  requireStl(packing);
}

TEST_CASE("npFEM reads its own templates at the packed places", "[executable][exports]") {
  const TemporaryFolder folder;
  const std::array<TriangleMesh, 2> own = {oddMesh(3), oddMesh(4)};  // off their centres
  writeMesh(folder.path() / "rbc.off", own[0]);
  writeMesh(folder.path() / "plt.off", own[1]);
  const auto requirePlaced = [&](const std::string& lumen, const Container& container) {
    ok(folder,
       lumen +
           " --cell-mesh PLT 5 plt.off --mesh-frame PLT file --cell-mesh RBC 9 rbc.off --mesh-frame RBC file "
           "--export npfem");
    const std::array<Membranes, 2> found = readNpfem(folder.path(), own);
    Membranes all;
    for (int type = 0; type < 2; ++type) {
      Membranes expected;
      for (const PosLine& line : readPos(folder.path() / (type == 0 ? "RBC.pos" : "PLT.pos")))
        expected.push_back(placed(centred(own[type]), placementOf(line)));
      // Single precision of the angles turns vertices 40 µm from the origin.
      requireSame(found[type], expected, Vec3::Zero(), 2 * singlePrecision);
      all.insert(all.end(), found[type].begin(), found[type].end());
    }
    CHECK(all.size() == 14);
    requireApart(all, container);
  };
  requirePlaced("18 18 18 --walls xyz", *makeBox({Vec3::Zero(), Vec3::Constant(18)}, {false, false, false}));
  requirePlaced("--cylinder z 8 18", *makeCylinder({8, 8, 9}, 2, 8, 18, false));
}

TEST_CASE("Exports that the other program would misread are refused", "[executable][exports]") {
  const TemporaryFolder folder;
  writeMesh(folder.path() / "a.off", oddMesh(3));
  const std::string own =
      "18 18 18 --walls xyz --cell-mesh RBC 3 a.off --mesh-frame RBC file --export npfem ";
  const auto refused = [&](const std::string& arguments, const std::string& message) {
    const Ran ran = run(folder.path(), arguments);
    CHECK(ran.exitCode == 2);
    CHECK_THAT(ran.err, Contains(message));
    CHECK_FALSE(fs::exists(folder.path() / "RBC.pos"));
  };
  TriangleMesh unused = oddMesh(3);
  unused.vertices.insert(unused.vertices.begin(), Vec3(3, -40, 0.5));
  for (Triangle& t : unused.triangles)
    for (int& corner : t) ++corner;
  writeMesh(folder.path() / "unused.off", unused);
  refused("18 18 18 --walls xyz --cell-mesh RBC 3 unused.off --mesh-frame RBC file --export npfem",
          "RBC has been repaired");
  refused("2000 2000 2000 --rbc 4000000 --validate --export lammps-molecular", "2568000000 atoms");
  refused("2000 2000 2000 --rbc 4000000 --validate --export stl", "5120000000 triangles");
  refused("18 18 18 --rbc 3 --export npfem", "RBC is not packed from a mesh file");
  refused("18 18 18 --cell-mesh RBC 3 a.off --export npfem", "RBC is turned or scaled");
  refused(own + "--mesh-scale RBC 0.9", "RBC is turned or scaled");
  refused(own + "--wbc 1", "red cells and platelets (PLT...) only, not WBC");
  refused(own + "--cell-mesh stiffRBC 3 a.off --mesh-frame stiffRBC file", "but stiffRBC is a second");
  refused("18 18 18 --cell-mesh RBC 3 a.off --mesh-frame RBC file --export npfem --ends periodic",
          "without --ends periodic");
}

TEST_CASE("Cells at open faces have positions in Mirheo's domain", "[executable][exports]") {
  const TemporaryFolder folder;
  ok(folder, "18 18 18 --dx 4 --plt 60 --export mirheo");  // the lumen begins at -2
  const TriangleMesh mesh = makeShape(*defaultModel("PLT"), 4.0)->mesh();
  Membranes expected;
  int below = 0;
  for (const PosLine& line : readPos(folder.path() / "PLT.pos")) {
    expected.push_back(placed(mesh, placementOf(line)));
    below += line.position.minCoeff() < 0.0;
  }
  CHECK(below > 0);
  const Vec3 domain(16, 16, 16);
  const Membranes found = readMirheo(folder.path(), "PLT", domain);
  requireSame(found, expected, domain, exact);
  requireApart(found, *makeBox({Vec3::Zero(), domain}, {true, true, true}));
}

TEST_CASE("A position that single precision rounds to the end of Mirheo's domain is at its beginning",
          "[executable][exports]") {
  const TemporaryFolder folder;
  fs::create_directory(folder.path() / "in");
  writeText(folder.path() / "in/PLT.pos", "2\n17.9999999999 9 -0.0000000001 20 30 40\n18 3 7 0 0 0\n");
  ok(folder, "18 18 18 --ends periodic --plt 2 --fixed in/PLT.pos --export mirheo");
  const Membranes found = readMirheo(folder.path(), "PLT", Vec3::Constant(18));
  CHECK(found.size() == 2);
  CHECK((found[0].vertices[0] - found[1].vertices[0]).norm() > 1.0);
}
