// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/mesh_file.h"

#if PACKMESH_CAT
#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#endif

#include "packMesh/core/error.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/packMesh/write_mesh.h"
#include "tests/support/catch.h"
#include "tests/support/decimal_comma.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;

namespace {

using Folder = test::TemporaryFolder;

std::string messageOf(const std::filesystem::path& file) {
  const std::string message = test::messageOf<InputError>([&] { readMesh(file); });
  CHECK_THAT(message, Contains(file.filename().string()));
  return message;
}

template <class T>
void put(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

template <class T>
void putBigEndian(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(std::string(std::make_reverse_iterator(raw + sizeof(T)), std::make_reverse_iterator(raw)));
}

std::string binaryStl(const TriangleMesh& mesh, std::string header = "made by a test") {
  header.resize(80, ' ');
  put(header, std::uint32_t(mesh.triangles.size()));
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) put(header, 0.0f);
    for (const int v : t)
      for (int k = 0; k < 3; ++k) put(header, float(mesh.vertices[v][k]));
    put(header, std::uint16_t(0));
  }
  return header;
}

std::string binaryPly(const TriangleMesh& mesh, bool bigEndian) {
  std::string bytes =
      std::string("ply\nformat binary_") + (bigEndian ? "big" : "little") + "_endian 1.0\nelement vertex " +
      std::to_string(mesh.vertices.size()) +
      "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar quality\nelement face " +
      std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vec3& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) bigEndian ? putBigEndian(bytes, float(v[k])) : put(bytes, float(v[k]));
    put(bytes, std::uint8_t(7));
  }
  for (const Triangle& t : mesh.triangles) {
    put(bytes, std::uint8_t(3));
    for (const int v : t) bigEndian ? putBigEndian(bytes, v) : put(bytes, v);
  }
  return bytes;
}

const char* tetrahedronOff =
    "OFF\n# a comment\n4 4 6\n0.1 0 0\n1.1234567890123456 0 0\n0 1 0\n0 0 1\n"
    "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";

bool same(const TriangleMesh& a, const TriangleMesh& b) {
  return a.vertices == b.vertices && a.triangles == b.triangles;
}

/// The mesh as an STL file numbers it: vertices by first appearance.
TriangleMesh byFirstAppearance(const TriangleMesh& mesh) {
  TriangleMesh out;
  std::vector<int> number(mesh.vertices.size(), -1);
  for (Triangle t : mesh.triangles) {
    for (int& v : t) {
      if (number[v] < 0) {
        number[v] = int(out.vertices.size());
        out.vertices.push_back(mesh.vertices[v]);
      }
      v = number[v];
    }
    out.triangles.push_back(t);
  }
  return out;
}

}  // namespace

TEST_CASE("readMesh preserves all numbers in every format", "[io]") {
  const Folder folder;
  TriangleMesh mesh = sample::sphere({1.0 / 3.0, 1e5, -2e-7}, 3.91, 7, 9);
  mesh.vertices[3].x() = std::numeric_limits<double>::denorm_min();
  for (const char* name : {"a.off", "a.ply", "a.obj", "A.OFF", "a.Ply", "a b é.OBJ"}) {
    CAPTURE(name);
    test::writeMesh(folder.path() / name, mesh);
    REQUIRE(same(readMesh(folder.path() / name), mesh));
  }
  for (const char* name : {"a.stl", "a.STL"}) {
    test::writeMesh(folder.path() / name, mesh);
    REQUIRE(same(readMesh(folder.path() / name), byFirstAppearance(mesh)));
  }
}

TEST_CASE("readMesh does not depend on the locale", "[io]") {
  const Folder folder;
  const test::DecimalComma comma;
  REQUIRE(readMesh(folder.write("a.off", tetrahedronOff)).vertices[1].x() == 1.1234567890123456);
}

TEST_CASE("readMesh reads binary STL and binary PLY of both byte orders", "[io]") {
  const Folder folder;
  TriangleMesh mesh = sample::sphere({0.5, 1.0, -2.0}, 4.0, 6, 8);
  for (Vec3& v : mesh.vertices)
    for (int k = 0; k < 3; ++k) {
      const volatile float rounded = float(v[k]);  // volatile: g++ 12 drops a vectorised round trip
      v[k] = rounded;
    }
  REQUIRE(same(readMesh(folder.write("a.stl", binaryStl(mesh))), byFirstAppearance(mesh)));
  REQUIRE(
      same(readMesh(folder.write("b.stl", binaryStl(mesh, "solid but binary"))), byFirstAppearance(mesh)));
  REQUIRE(same(readMesh(folder.write("a.ply", binaryPly(mesh, false))), mesh));
  REQUIRE(same(readMesh(folder.write("b.ply", binaryPly(mesh, true))), mesh));
}

TEST_CASE("readMesh asks for text instead of binary OFF", "[io]") {
  const Folder folder;
  for (const char* head : {"OFF BINARY\n", "COFF BINARY\n"})
    CHECK_THAT(messageOf(folder.write("a.off", std::string(head) + std::string(64, '\0'))),
               Contains("a.off:1: expected OFF as text, or another format, found 'BINARY'"));
}

TEST_CASE("readMesh rejects counts larger than the file", "[io]") {
  const Folder folder;
  const std::string ply = binaryPly(sample::box(Vec3::Zero(), Vec3::Ones()), false);
  for (const std::string element : {"vertex 8", "face 12"}) {
    std::string text = ply;
    const std::size_t at = text.find("element " + element);
    REQUIRE(at != text.npos);
    text.replace(at, 8 + element.size(), "element " + element.substr(0, element.find(' ')) + " 200000000");
    CHECK_THAT(messageOf(folder.write("a.ply", text)), Contains("complete binary PLY"));
  }
}

TEST_CASE("readMesh keeps collapsed, duplicate and non-manifold faces", "[io]") {
  const Folder folder;
  const TriangleMesh mesh = readMesh(folder.write(
      "a.off",
      "OFF 5 6 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 0 -1\n3 0 1 2\n3 0 1 2\n3 0 1 3\n3 0 1 4\n3 0 0 1\n"
      "3 1 0 3\n"));
  REQUIRE(mesh.triangles.size() == 6);
  REQUIRE(readMesh(folder.write("a.stl", binaryStl(mesh))).triangles.size() == 6);
  test::writeMesh(folder.path() / "b.stl", mesh);
  REQUIRE(readMesh(folder.path() / "b.stl").triangles.size() == 6);
}

TEST_CASE("readMesh reads what other readers read, and says what is odd", "[io]") {
  const Folder folder;
  const auto notesOf = [&](const std::filesystem::path& file, std::size_t triangles) {
    std::vector<std::string> notes;
    CHECK(readMesh(file, &notes).triangles.size() == triangles);
    return notes.empty() ? std::string() : notes.at(0);
  };
  const TriangleMesh mesh = sample::box(Vec3::Zero(), Vec3::Ones());
  test::writeMesh(folder.path() / "a.stl", mesh);
  std::ifstream in(folder.path() / "a.stl");
  std::string text((std::istreambuf_iterator<char>(in)), {});
  CHECK(notesOf(folder.write("b.stl", text + text), 24).empty());  // two solids
  const std::string whole = text.substr(0, text.rfind("endsolid"));
  CHECK_THAT(notesOf(folder.write("c.stl", whole), 12), Contains("c.stl: a solid has no 'endsolid'"));
  CHECK_THAT(notesOf(folder.write("d.stl", whole + whole), 24), Contains("'endsolid'"));
  CHECK_THAT(messageOf(folder.write("e.stl", whole.substr(0, whole.rfind("endloop")))),
             Contains("expected 'endloop'"));
  CHECK_THAT(notesOf(folder.write("f.stl", binaryStl(mesh, "solid") + "abc"), 12),
             Contains("ignored 3 bytes"));
  CHECK_THAT(
      messageOf(folder.write("g.stl", "version https://git-lfs.github.com/spec/v1\noid sha256:1\nsize 9\n")),
      Contains("git lfs pull"));
  CHECK_THAT(messageOf(folder.write("h.off", "OFF\n3 1 0\n0,5 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")),
             Contains("decimal point"));
  CHECK_THAT(messageOf(folder.write("vein.vtp", "<VTKFile/>")),
             Contains("packmesh surface vein.vtp vein.off"));
}

TEST_CASE("readMesh merges equal vertices in the order of their first occurrence", "[io]") {
  const Folder folder;
  const TriangleMesh mesh =
      readMesh(folder.write("a.off", "OFF\n5 2 0\n0 0 0\n1 0 0\n0 1 0\n-0.0 0 0\n5 5 5\n3 0 1 2\n3 3 2 4\n"));
  REQUIRE(mesh.vertices.size() == 4);
  REQUIRE(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}});
}

TEST_CASE("readMesh triangulates polygons and supports OBJ indices and PLY properties", "[io]") {
  const Folder folder;
  const TriangleMesh obj = readMesh(folder.write("a.obj",
                                                 "# comment\r\nmtllib none.mtl\r\no thing\r\nv 0 0 0\r\nv +1 "
                                                 "0 0 1.0\r\nv 1 1 0\r\nv 0 1e0 0\r\nvt 0 0\r\n"
                                                 "vn 0 0 1\r\ns off\r\nusemtl x\r\nf 1/1/1 2/1/1 3/1/1 "
                                                 "4/1/1\r\nf -4 -3 -2\r\nf 1//1 2//1 3//1\r\nf 1/1 2/1 3/1"));
  REQUIRE(obj.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {0, 1, 2}, {0, 1, 2}});
  // An arrowhead must be cut from its notch.
  const TriangleMesh arrow =
      readMesh(folder.write("arrow.off",
                            "COFF\n4 1 0\n0 0 0 1 1 1 1\n2 0.9 0 0 0 0 1\n0 2 0 0 0 0 1\n0.5 0.6 0 1 1 1 1\n"
                            "4 0 1 2 3 0.5 0.5 0.5\n"));
  REQUIRE(arrow.triangles.size() == 2);
  for (const Triangle& t : arrow.triangles)
    REQUIRE(
        (arrow.vertices[t[1]] - arrow.vertices[t[0]]).cross(arrow.vertices[t[2]] - arrow.vertices[t[0]]).z() >
        0.0);
  const TriangleMesh ply = readMesh(folder.write(
      "a.ply",
      "ply\nformat ascii 1.0\ncomment c\nelement vertex 3\nproperty uchar red\nproperty double z\nproperty "
      "double y\n"
      "property double x\nelement face 1\nproperty uchar flag\nproperty list uchar int vertex_index\n"
      "end_header\n255 3 2 1\n0 0 1 0\n0 0 0 1\n1 3 0 1 2\n"));
  REQUIRE(ply.vertices[0] == Vec3(1, 2, 3));
  REQUIRE(ply.triangles.size() == 1);
}

TEST_CASE("readMesh reads PLY with properties and comments of any kind, text and binary alike", "[io]") {
  const Folder folder;
  const auto header = [](const std::string& format) {
    return "ply\nformat " + format +
           " 1.0\ncomment element face 9 end_header\nelement vertex 3\nproperty list uchar short near\n"
           "property float x\nproperty float y\nproperty float z\nelement face 1\nproperty uchar flag\n"
           "property list uint uint vertex_indices\nproperty list uchar float texcoord\nend_header\n";
  };
  const std::string text = header("ascii") + "0 1 2 3\n1 7 4 5 6\n2 8 9 7 8 10\n1 3 2 1 0 1 0.5\n";
  std::string binary = header("binary_little_endian");
  for (int v = 0; v < 3; ++v) {
    put(binary, std::uint8_t(v));
    for (int near = 0; near < v; ++near) put(binary, std::int16_t(near));
    for (int k = 0; k < 3; ++k) put(binary, v == 2 && k == 2 ? 10.0f : float(3 * v + k + 1));
  }
  put(binary, std::uint8_t(1));
  for (const std::uint32_t number : {3, 2, 1, 0}) put(binary, number);
  put(binary, std::uint8_t(1));
  put(binary, 0.5f);
  for (const std::string& content : {text, binary}) {
    const TriangleMesh mesh = readMesh(folder.write("a.ply", content));
    CHECK(mesh.vertices == std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}, {7, 8, 10}});
    CHECK(mesh.triangles == std::vector<Triangle>{{2, 1, 0}});
  }
}

#if PACKMESH_CAT
// Why packMesh has readers of its own (mesh_readers.h). If this fails, OpenMesh's may be good enough by now.
TEST_CASE("OpenMesh's readers round coordinates, leave out faces and accept damage", "[.][openmesh]") {
  struct Traits : OpenMesh::DefaultTraits {
    using Point = OpenMesh::Vec3d;
  };
  using Mesh = OpenMesh::PolyMesh_ArrayKernelT<Traits>;
  const Folder folder;
  const auto read = [](const std::filesystem::path& file) {
    Mesh mesh;
    CHECK(OpenMesh::IO::read_mesh(mesh, file.string()));
    return mesh;
  };
  TriangleMesh mesh = sample::box(Vec3::Zero(), Vec3::Constant(1.0 / 3.0));
  for (const char* name : {"a.off", "a.ply", "a.obj", "a.stl"}) {
    CAPTURE(name);
    test::writeMesh(folder.path() / name, mesh);
    const Mesh rounded = read(folder.path() / name);
    CHECK(rounded.n_faces() == 12);
    for (const auto v : rounded.vertices())
      if (rounded.point(v)[0] > 0.0) CHECK(rounded.point(v)[0] == double(1.0f / 3.0f));
    for (const Vec3& v : readMesh(folder.path() / name).vertices)
      if (v.x() > 0.0) CHECK(v.x() == 1.0 / 3.0);
  }
  mesh.triangles.push_back({0, 0, 1});
  CHECK(read(folder.write("collapsed.stl", binaryStl(mesh))).n_faces() == 12);
  CHECK(read(folder.write("nonsense.obj", "v 0 0 0\nv one 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n")).n_faces() == 1);
  const std::string stl = binaryStl(mesh);
  CHECK(read(folder.write("truncated.stl", stl.substr(0, 400))).n_faces() == 0);
}
#endif

TEST_CASE("readMesh reads text STL as other programs write it", "[io]") {
  const Folder folder;
  const std::string facet =
      "FACET normal nan nan nan\n OUTER LOOP\n vertex 0 0 0\n vertex 1 0 0\n vertex 0 1 0\n "
      "endloop\nendfacet\n";
  REQUIRE(readMesh(folder.write("a.stl", "solid a name with facet\r\n" + facet +
                                             "endsolid a name\nsolid b\n" + facet + "endsolid"))
              .triangles.size() == 2);
}

TEST_CASE("readMesh explains errors in a file", "[io][messages]") {
  const Folder folder;
  std::filesystem::create_directories(folder.path() / "folder.stl");
  CHECK_THAT(messageOf(folder.path() / "none.stl"), Contains("no such file"));
  CHECK_THAT(messageOf(folder.path() / "folder.stl"), Contains("is a folder, expected a mesh file"));
  const std::string off = tetrahedronOff, three = "0 0 0\n1 0 0\n0 1 0\n",
                    face = "OFF\n3 1 0\n" + three + "3 ", corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf ",
                    facet =
                        "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                        "endloop\nendfacet\n";
  const TriangleMesh cube = sample::box(Vec3::Zero(), Vec3::Ones());
  const std::string binary = binaryStl(cube);
  std::string nan = binary;
  const float value = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(&nan[84 + 12], &value, 4);
  struct Wrong {
    std::string name, content, message;
  };
  for (const auto& [name, content, message] : std::vector<Wrong>{
           {"a.vtk", "x", "expected a mesh file ending in .stl, .off, .ply or .obj"},
           {"noending", "x", "no extension"},
           {"empty.stl", "", "empty file"},
           {"blank.obj", " \n\n", "empty file"},
           {"garbage.stl", "garbage", "text that begins with 'solid'"},
           {"garbage2.stl", std::string(500, 'x'), "stated in its header"},
           {"garbage.off", "garbage", ":1: expected 'OFF', found 'garbage'"},
           {"garbage.ply", "garbage", "beginning with 'ply'"},
           {"garbage.obj", "%garbage", "keyword"},
           {"text.obj", "just some words", "expected triangles, found none"},
           {"4.off", "4OFF\n1 1 1\n", "expected 'OFF'"},
           {"t1.off", off.substr(0, off.find("3 1 2 3")), "expected face 3 of 4"},
           {"t2.off", off.substr(0, off.find("0 0 1")), "expected vertex 4 of 4"},
           {"t3.off", "OFF\n", "numbers of vertices"},
           {"i1.off", face + "0 1 3\n", ":6: expected a vertex index between 0 and 2, found '3'"},
           {"i2.off", face + "0 1 x\n", "found 'x'"},
           {"i3.off", face + "0 1\n", "the end of the line"},
           {"n1.off", "OFF\n3 1 0\n0 nan 0\n",
            ":3: expected a coordinate that is a finite number, found 'nan'"},
           {"n2.off", "OFF\n3 1 0\n0 1e999 0\n", "finite"},
           {"huge.off", "OFF\n99999999999999999999 1 0\n", "the number of vertices"},
           {"none.off", "OFF\n0 0 0\n", "found none"},
           {"f1.obj", corners + "1 2 4\n", "refers to vertex 4"},
           {"f2.obj", corners + "1 2 -4\n", ":4: expected the index"},
           {"f3.obj", corners + "1 2\n", "at least three corners"},
           {"f4.obj", corners + "1 2 a\n", "found 'a'"},
           {"t1.stl", facet + "vertex 0 0 0\n", "'facet' or 'endsolid'"},
           {"t2.stl", facet.substr(0, 75), "expected"},
           {"t3.stl", "solid x\nendsolid x\n", "found none"},
           {"n.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 inf 0\n", ":4:"},
           {"t4.stl", binary.substr(0, 400),
            "expected a binary STL file of 684 bytes for the 12 triangles stated in its header, found 400"},
           {"n2.stl", nan, "vertex 1 has a coordinate that is not a finite number"},
           {"t.ply", binaryPly(cube, false).substr(0, 300), "complete binary PLY"},
           {"h.ply", "ply\nformat ascii 1.0\n", "end_header"},
           {"p.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
            "x, y and z"}}) {
    CAPTURE(name);
    CHECK_THAT(messageOf(folder.write(name, content)), Contains(message));
  }
}
