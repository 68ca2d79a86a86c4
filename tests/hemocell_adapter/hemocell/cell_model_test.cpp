// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/cell_model.h"

#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <iomanip>
#include <sstream>

#include "packMesh/core/error.h"
#include "tests/support/catch.h"
#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;
using namespace packmesh::hemocell;
namespace fs = std::filesystem;

namespace {

std::string material(const std::string& tags) {
  return "<?xml version=\"1.0\" ?>\n<hemocell>\n<MaterialModel>\n" + tags +
         "\n</MaterialModel>\n</hemocell>\n";
}

/// Order-sensitive (FNV-1a over the vertex numbers).
std::uint64_t checksum(const std::vector<Triangle>& triangles) {
  std::uint64_t sum = 14695981039346656037u;
  for (const Triangle& t : triangles)
    for (int v : t)
      for (int byte = 0; byte < 4; ++byte)
        sum = (sum ^ (static_cast<std::uint32_t>(v) >> 8 * byte & 255u)) * 1099511628211u;
  return sum;
}

/// The cases of tests/data/templates.txt.
CellModel modelOf(const std::string& name) {
  if (name == "PLT_512") {
    CellModel model = *defaultModel("PLT");
    model.minNumTriangles = 129;
    return model;
  }
  if (name == "RBC_20") {
    CellModel model = *defaultModel("RBC");
    model.minNumTriangles = 20;
    return model;
  }
  return *defaultModel(name);
}

double signedDistance(const ProfileSurface& surface, const Vec3& v) {
  const double s = surface.a * v.x() * v.x() + surface.c * v.z() * v.z();
  double value = 0.0, slope = 0.0;
  for (int k = 5; k >= 0; --k) value = value * s + surface.p[k];
  for (int k = 5; k >= 1; --k) slope = slope * s + k * surface.p[k];
  const double f = v.y() * v.y() - value;
  const double g = 2.0 * Vec3(slope * surface.a * v.x(), v.y(), slope * surface.c * v.z()).norm();
  return f / (0.5 * g + std::sqrt(std::max(0.0, 0.25 * g * g - f)));
}

/// An ASCII STL of a box.
std::string boxStl(double x, double y, double z, bool insideOut = false) {
  const Vec3 v[8] = {{0, 0, 0}, {x, 0, 0}, {0, y, 0}, {x, y, 0}, {0, 0, z}, {x, 0, z}, {0, y, z}, {x, y, z}};
  const Triangle triangles[] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  std::ostringstream text;
  text << "solid box\n";
  for (const Triangle& t : triangles) {
    text << "facet normal 0 0 0\nouter loop\n";
    for (int k = 0; k < 3; ++k) {
      const Vec3& p = v[t[insideOut ? 2 - k : k]];
      text << "vertex " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
    }
    text << "endloop\nendfacet\n";
  }
  text << "endsolid box\n";
  return text.str();
}

}  // namespace

TEST_CASE("Constructions have names", "[cell]") {
  for (Construction c : {Construction::rbcFromSphere, Construction::ellipsoidFromSphere,
                         Construction::wbcSphere, Construction::meshFromStl})
    CHECK(constructionFromString(toString(c)) == c);
  CHECK(toString(Construction::meshFromStl) == "MESH_FROM_STL");
  CHECK(!constructionFromString("rbc_from_sphere"));
  CHECK(defaultConstruction("RBC_m", false) == Construction::rbcFromSphere);
  CHECK(defaultConstruction("PLT_mko", false) == Construction::ellipsoidFromSphere);
  CHECK(defaultConstruction("WBC", false) == Construction::wbcSphere);
  CHECK(defaultConstruction("RBC", true) == Construction::meshFromStl);
  CHECK(!defaultConstruction("vRBC", false));
  CHECK(defaultEllipsoid("vRBC") == std::array<double, 3>{3.5, 6.0, 11.0});
  CHECK(!defaultEllipsoid("RBC"));
  CHECK(!defaultModel("vRBC"));
}

TEST_CASE("A cell's XML is read as HemoCell reads it, blanks and comments included", "[cell]") {
  const test::TemporaryFolder folder;
  const CellModel rbc = readCellXml(
      folder.write(
          "RBC.xml",
          material("<kBend> 80.0 </kBend><radius> 3.91e-6 <!-- [3.91] --> </radius>\n"
                   "<minNumTriangles>\n 600 </minNumTriangles><Volume> 90 </Volume><InnerEdges><Edge> 1 2 "
                   "</Edge></InnerEdges>")),
      "RBC");
  CHECK(rbc.name == "RBC");
  CHECK(rbc.construction == Construction::rbcFromSphere);
  CHECK(rbc.radius == Approx(3.91).epsilon(1e-14));
  CHECK(rbc.minNumTriangles == 600);
  CHECK(rbc.hemocellVolume == 90.0);

  const CellModel plt = readCellXml(
      folder.write("RBC.xml", material("<radius>+1.25E-6</radius><minNumTriangles>66</minNumTriangles>"
                                       "<aspectRatio>0.434782608696</aspectRatio>")),
      "PLT");
  CHECK(plt.construction == Construction::ellipsoidFromSphere);
  CHECK(plt.aspectRatio == 0.434782608696);
  CHECK(!plt.hemocellVolume);

  const fs::path stl =
      folder.write("RBC.xml", material("<StlFile> cell.stl </StlFile><radius>5.4e-6</radius>"));
  CHECK(readCellXml(stl, "RBC").construction == Construction::meshFromStl);
  CHECK(readCellXml(stl, "vRBC").stlFile == folder.path() / "cell.stl");
  CHECK(readCellXml(
            folder.write("RBC.xml", material("<radius>4e-6</radius><minNumTriangles>600</minNumTriangles>")),
            "Tumour", Construction::wbcSphere)
            .construction == Construction::wbcSphere);
}

TEST_CASE("Errors in a cell's XML are reported with file, line, tag, value and expectation", "[cell]") {
  const test::TemporaryFolder folder;
  const std::string radius = "<radius>3.91e-6</radius>", triangles = "<minNumTriangles>600</minNumTriangles>";
  struct Case {
    std::string text, expected;
  };
  const Case cases[] = {
      {"", "is empty or not text"},
      {"<hemocell><MaterialModel></hemocell>", ":1: is not well-formed XML"},
      {"<?xml version=\"1.0\" ?>\n<Hemocell></Hemocell>", ":2: root is <Hemocell>, expected <hemocell>"},
      {"<hemocell>\n</hemocell>", ":1: expected <MaterialModel>"},
      {material(triangles),
       ":3: <MaterialModel> has no <radius>, expected the radius in metres, e.g. 3.91e-6"},
      {material(radius), "no <minNumTriangles>, expected a whole number"},
      {material(triangles + "\n<radius> 3,91e-6 </radius>"),
       ":5: <radius> '3,91e-6', expected the radius in metres"},
      {material(triangles + "<radius>3.91</radius>"), "<radius> '3.91', expected the radius in metres"},
      {material(triangles + "<radius>-3.91e-6</radius>"), "'-3.91e-6'"},
      {material(triangles + "<radius>nan</radius>"), "'nan'"},
      {material(triangles + "<radius>inf</radius>"), "'inf'"},
      {material(triangles + "<radius>1e-999</radius>"), "'1e-999'"},
      {material(triangles + "<radius> </radius>"), "<radius> ''"},
      {material(triangles + "<radius>3.91e-6 m</radius>"), "'3.91e-6 m'"},
      {material(triangles + radius + "\n" + radius),
       ":5: <radius> occurs here and on line 4, expected only one"},
      {material(radius + "<minNumTriangles>0</minNumTriangles>"),
       "<minNumTriangles> '0', expected a whole number"},
      {material(radius + "<minNumTriangles>600.5</minNumTriangles>"), "'600.5'"},
      {material(radius + "<minNumTriangles>99999999999</minNumTriangles>"), "'99999999999'"},
      {material(radius + triangles + "<aspectRatio>0</aspectRatio>"),
       "<aspectRatio> '0', expected thickness"},
      {material(radius + triangles + "<Volume>-1</Volume>"), "<Volume> '-1', expected the volume"},
      {material(radius + "<StlFile> </StlFile>"), "<StlFile> '', expected the name of an STL file"},
  };
  for (const Case& c : cases) {
    CAPTURE(c.text);
    const fs::path file = folder.write("RBC.xml", c.text);
    CHECK_THROWS_WITH(readCellXml(file, "RBC"), Contains(c.expected) && Contains(file.string()));
  }
  const fs::path good = folder.write("RBC.xml", material(radius + triangles));
  CHECK_THROWS_WITH(readCellXml(good, "PLT"), Contains("has no <aspectRatio>"));
  CHECK_THROWS_WITH(readCellXml(good, "RBC", Construction::meshFromStl), Contains("has no <StlFile>"));
  CHECK_THROWS_WITH(readCellXml(good, "Sickle"),
                    Contains("the construction of Sickle") && Contains("WBC_SPHERE"));
  CHECK_THROWS_WITH(readCellXml(folder.path() / "none.xml", "RBC"), Contains("none.xml: no such file"));
  CHECK_THROWS_WITH(readCellXml(folder.path(), "RBC"), Contains("is a folder"));
  CHECK_THROWS_AS(readCellXml(folder.path(), "RBC"), InputError);
}

TEST_CASE("Templates equal HemoCell's, including vertex numbers and triangle order", "[cell]") {
  std::ifstream in(std::string(test::sourceFolder) + "/tests/data/templates.txt");
  REQUIRE(in);
  int cases = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream head(line);
    std::string name;
    double dx, volume;
    std::size_t vertices, triangles;
    std::uint64_t sum;
    REQUIRE(head >> name >> dx >> vertices >> triangles >> volume >> sum);
    CAPTURE(name, dx);
    const TriangleMesh mesh = buildTemplate(modelOf(name), dx);
    REQUIRE(mesh.vertices.size() == vertices);
    REQUIRE(mesh.triangles.size() == triangles);
    CHECK(checksum(mesh.triangles) == sum);
    CHECK(std::abs(signedVolume(mesh) - volume) < 1e-7);
    for (int n = 0; n < 8; ++n) {
      std::size_t index;
      Vec3 v;
      REQUIRE(in >> index >> v.x() >> v.y() >> v.z());
      REQUIRE(index < vertices);
      CHECK((mesh.vertices[index] - v).norm() < 1e-7);  // sqrt(1 - r²) at the rim is good to 1e-8 only
    }
    ++cases;
  }
  CHECK(cases == 10);
}

// Writes a new tests/data/templates.txt to $PACKMESH_TEMPLATES; only after the [golden] test has passed.
TEST_CASE("Make templates.txt", "[.][make-templates]") {
  const char* file = std::getenv("PACKMESH_TEMPLATES");
  if (!file) return;
  std::ofstream out(file);
  out << "# Template meshes, made by `unit_tests \"[make-templates]\"` after they agreed with HemoCell's "
         "own.\n"
         "# name dx[µm] vertices triangles volume[µm³] checksum-of-triangles, then 8 vertices: number x y z "
         "[µm]\n";
  out << std::setprecision(12);
  const auto write = [&](const std::string& name, double dx) {
    const TriangleMesh mesh = buildTemplate(modelOf(name), dx);
    out << name << ' ' << dx << ' ' << mesh.vertices.size() << ' ' << mesh.triangles.size() << ' '
        << signedVolume(mesh) << ' ' << checksum(mesh.triangles) << '\n';
    for (std::size_t n = 0; n < 8; ++n) {
      const std::size_t index = n * (mesh.vertices.size() - 1) / 7;
      const Vec3& v = mesh.vertices[index];
      out << index << ' ' << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
    }
  };
  for (const char* name : {"RBC", "PLT", "WBC", "RBC_m", "PLT_m", "PLT_mko", "RBC_20", "PLT_512"})
    write(name, 0.5);
  write("RBC", 0.0);
  write("RBC", 0.25);
}

TEST_CASE("Templates are centred, oriented outwards and as large as HemoCell's", "[cell]") {
  const TriangleMesh rbc = buildTemplate(*defaultModel("RBC"), 0.5);
  CHECK(signedVolume(rbc) == Approx(81.116).margin(5e-4));
  CHECK(signedVolume(buildTemplate(*defaultModel("RBC"), 0.0)) == Approx(81.052).margin(5e-4));
  CHECK(boundingBox(rbc).center().norm() < 1e-14);
  CHECK(boundingBox(rbc).size().y() == Approx(2.29).margin(0.005));
  CHECK(signedVolume(buildTemplate(*defaultModel("PLT"), 0.5)) == Approx(3.25).margin(0.005));
  CHECK(signedVolume(buildTemplate(*defaultModel("WBC"), 0.5)) == Approx(265.9).margin(0.05));
}

TEST_CASE("A template from an STL is scaled to its largest extent, rotated and inflated", "[cell]") {
  const test::TemporaryFolder folder;
  CellModel model;
  model.name = "box";
  model.construction = Construction::meshFromStl;
  model.radius = 3.0;
  model.stlFile = folder.write("box.stl", boxStl(1, 2, 4));
  // (x, y, z) -> (-y, -z, x), times 6/4.
  const TriangleMesh mesh = buildTemplate(model, 0.0);
  REQUIRE(mesh.vertices.size() == 8);
  CHECK((boundingBox(mesh).size() - Vec3(3.0, 6.0, 1.5)).norm() < 1e-12);
  CHECK((mesh.vertices[0] - Vec3(1.5, 3.0, -0.75)).norm() < 1e-12);
  CHECK((mesh.vertices[1] - Vec3(-1.5, 3.0, -0.75)).norm() < 1e-12);  // (0, 2, 0) appears second
  CHECK(signedVolume(mesh) == Approx(27.0));
  CHECK(signedVolume(buildTemplate(model, 0.5)) > 27.0);

  std::vector<std::string> warnings;
  CHECK(makeShape(model, 0.0, &warnings)->volume() == Approx(27.0));
  CHECK(warnings.empty());
  model.stlFile = folder.write("insideOut.stl", boxStl(1, 2, 4, true));
  CHECK(makeShape(model, 0.0, &warnings)->volume() == Approx(27.0));
  CHECK(warnings.size() == 1);
  model.stlFile = folder.path() / "none.stl";
  CHECK_THROWS_AS(buildTemplate(model, 0.5), InputError);

  warnings.clear();
  const auto shape = makeShapeFromFile(folder.path() / "box.stl", 2.0, MeshFrame::file, 0.5, warnings);
  CHECK(shape->volume() == Approx(64.0));
  CHECK(boundingBox(shape->mesh()).center().norm() < 1e-12);
  CHECK(boundingBox(shape->mesh()).size().isApprox(Vec3(2, 4, 8)));
  CHECK_THROWS_AS(makeShapeFromFile(folder.path() / "box.stl", 0.0, MeshFrame::file, 0.5, warnings),
                  InputError);
}

TEST_CASE("A mesh file in HemoCell's frame gives the template of MESH_FROM_STL, vertex by vertex", "[cell]") {
  const test::TemporaryFolder folder;
  for (const bool insideOut : {false, true}) {
    CellModel model;
    model.construction = Construction::meshFromStl;
    model.stlFile = folder.write("box.stl", boxStl(1, 2, 4, insideOut));
    model.radius = 3.0;
    std::vector<std::string> warnings, others;
    const auto fromXml = makeShape(model, 0.5, &warnings);
    const auto fromFile = makeShapeFromFile(model.stlFile, 1.5, MeshFrame::hemocell, 0.5, others);
    CHECK(warnings == others);
    CHECK(warnings.size() == (insideOut ? 1 : 0));
    REQUIRE(fromFile->mesh().vertices.size() == 8);
    CHECK(fromFile->mesh().triangles == fromXml->mesh().triangles);
    for (std::size_t v = 0; v < 8; ++v)
      CHECK((fromFile->mesh().vertices[v] - fromXml->mesh().vertices[v]).norm() < 1e-12);
    CHECK(boundingBox(fromFile->mesh()).size().isApprox(Vec3(3, 6, 1.5), 1e-3));  // (-y, -z, x)
  }
}

TEST_CASE("The closed form contains the template and is close to it everywhere", "[cell]") {
  for (double dx : {0.0, 0.25, 0.5, 1.0})
    for (int triangles : {0, 20, 80, 320, 5000})
      for (const char* name : {"RBC", "RBC_m", "PLT", "PLT_m", "PLT_mko", "WBC"}) {
        CAPTURE(name, dx, triangles);
        CellModel model = *defaultModel(name);
        if (triangles > 0) model.minNumTriangles = triangles;
        const TriangleMesh mesh = buildTemplate(model, dx);
        const ProfileSurface surface = *profileOf(model, mesh);
        double least = 1.0, most = -1.0;
        for (const Vec3& v : mesh.vertices) {
          least = std::min(least, signedDistance(surface, v));
          most = std::max(most, signedDistance(surface, v));
        }
        CHECK(most < 1e-7);
        CHECK(least > -2e-4 * dx - 1e-9);
      }
  CHECK(!profileOf({"", Construction::meshFromStl, 1.0, 0, 1.0, {}, {}, {}}, {}));
}

TEST_CASE("Shapes of HemoCell's cells and of ellipsoids have the expected volume and extent", "[cell]") {
  CHECK(makeShape(*defaultModel("RBC"), 0.5)->volume() == Approx(81.116).margin(5e-4));
  CHECK(std::holds_alternative<ProfileSurface>(makeShape(*defaultModel("PLT"), 0.5)->field()));
  const auto vrbc = makeEllipsoid(3.5, 6.0, 11.0);
  CHECK(vrbc->volume() == Approx(M_PI / 6.0 * 3.5 * 6.0 * 11.0).epsilon(0.02));
  CHECK((boundingBox(vrbc->mesh()).size() - Vec3(3.5, 6.0, 11.0)).norm() < 0.05);
  CHECK_THROWS_AS(makeEllipsoid(0.0, 1.0, 1.0), InputError);
  CHECK_THROWS_AS(makeEllipsoid(1.0, std::nan(""), 1.0), InputError);
}

TEST_CASE("Constants of platelets and white cells have the links through the cell", "[cell_model]") {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "cell.xml";
  const std::string four =
                        "<kLink> 25 </kLink><kBend> 250 </kBend><kVolume> 100 </kVolume><kArea> 8 </kArea>\n",
                    links = "<InnerEdges>\n<Edge> 60 65 </Edge><Edge>0\t4</Edge></InnerEdges>",
                    core =
                        "<kInnerRigid> 6.4e-12 </kInnerRigid><kCytoskeleton> 6.4e-15 </kCytoskeleton>"
                        "<coreRadius> 2.5e-6 </coreRadius><radius> 4e-6 </radius>";
  const auto read = [&](const std::string& name, const std::string& tags) {
    std::ofstream(file) << material(tags);
    return readMembrane(file, name).constants.value();
  };
  const MembraneConstants platelet = read("PLT_m", four + links + core);
  CHECK(platelet.model == MembraneModel::platelet);
  CHECK(platelet.innerLinks == std::vector<std::array<int, 2>>{{60, 65}, {0, 4}});
  CHECK(platelet.core.force == 0.0);
  CHECK(read("PLT", four).innerLinks.empty());
  const MembraneConstants white = read("WBC_HO", four + links + core);
  CHECK(white.model == MembraneModel::whiteCell);
  CHECK(white.innerLinks.size() == 2);
  CHECK(white.core.force == Approx(6.4));
  CHECK(white.core.radius == Approx(2.5));
  CHECK(white.cytoskeleton.force == Approx(6.4e-3));
  CHECK(white.cytoskeleton.radius == Approx(4.0));
  const MembraneConstants red = read("RBC", four + links + core);
  CHECK(red.model == MembraneModel::highOrder);
  CHECK(red.innerLinks.empty());
  for (const char* const pair : {"1", "1 2 3", "a b", "-1 2", "3 3", "1 2147483648", ""})
    CHECK_THROWS_WITH(read("PLT", four + "<InnerEdges><Edge> " + pair + " </Edge></InnerEdges>"),
                      Contains("cell.xml:5: <Edge> '" + std::string(pair) +
                               "', expected two different numbers of vertices"));
  CHECK_THROWS_WITH(read("WBC", four + "<coreRadius> -1 </coreRadius>"),
                    Contains("<coreRadius> '-1', expected a length"));
}

TEST_CASE("HemoCell's own platelets and white cells have its own links", "[cell_model]") {
  const TriangleMesh platelet = buildTemplate(*defaultModel("PLT"), 0.5),
                     white = buildTemplate(*defaultModel("WBC"), 0.5);
  const MembraneConstants ofPlatelet = defaultMembrane("PLT", platelet),
                          ofWhite = defaultMembrane("WBC", white);
  CHECK(ofPlatelet.innerLinks.size() == 21);
  CHECK(ofWhite.innerLinks.size() == 321);
  const auto middle = [](const TriangleMesh& mesh, const std::array<int, 2>& link) {
    return (0.5 * (mesh.vertices[link[0]] + mesh.vertices[link[1]])).norm();
  };
  for (const auto& link : ofWhite.innerLinks) CHECK(middle(white, link) < 1e-6);
  CHECK(defaultMembrane("RBC", platelet).innerLinks.empty());
}
