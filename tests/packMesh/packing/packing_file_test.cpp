// SPDX-License-Identifier: AGPL-3.0-or-later
#include <hdf5.h>

#include "packMesh/core/error.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/packing/packing_file.h"
#include "tests/packMesh/mesh/test_meshes.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;

namespace {

std::vector<NamedMesh> twoMeshes() {
  return {{"RBC 1", test::icosphere(1, 1.0 / 3.0), "cell"},
          {"a box\nwith a line break", sample::box({1, 1, 1}, {2, 3, 4}), "wall layer"}};
}

std::filesystem::path scratch(const std::string& name) {
  const auto folder = std::filesystem::temp_directory_path() / "packMesh_hdf5_meshes_test";
  std::filesystem::create_directories(folder);
  return folder / name;
}

}  // namespace

TEST_CASE("Meshes in an HDF5 file are numbered groups", "[io]") {
  const auto file = scratch("two.h5");
  writeMeshes(file, twoMeshes());
  const hid_t in = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  REQUIRE(in >= 0);
  const auto text = [](hid_t at, const char* name) {
    const hid_t attribute = H5Aopen(at, name, H5P_DEFAULT), type = H5Aget_type(attribute);
    std::string value(H5Tget_size(type), '\0');
    H5Aread(attribute, type, value.data());
    H5Tclose(type);
    H5Aclose(attribute);
    return std::string(value.c_str());
  };
  CHECK(text(in, "unit") == "µm");
  const std::vector<NamedMesh> meshes = twoMeshes();
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const hid_t group = H5Gopen2(in, ("/meshes/" + std::to_string(i)).c_str(), H5P_DEFAULT);
    REQUIRE(group >= 0);
    CHECK(text(group, "name") == meshes[i].name);
    CHECK(text(group, "kind") == meshes[i].kind);
    TriangleMesh mesh;
    mesh.vertices.resize(meshes[i].mesh.vertices.size());
    mesh.triangles.resize(meshes[i].mesh.triangles.size());
    const auto read = [&](const char* name, hid_t type, void* data, std::size_t rows) {
      const hid_t set = H5Dopen2(group, name, H5P_DEFAULT), space = H5Dget_space(set);
      hsize_t size[2];
      REQUIRE(H5Sget_simple_extent_dims(space, size, nullptr) == 2);
      REQUIRE(size[0] == rows);
      REQUIRE(size[1] == 3);
      CHECK(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0);
      H5Sclose(space);
      H5Dclose(set);
    };
    read("vertices", H5T_NATIVE_DOUBLE, mesh.vertices.data(), mesh.vertices.size());
    read("triangles", H5T_NATIVE_INT, mesh.triangles.data(), mesh.triangles.size());
    CHECK(mesh.vertices == meshes[i].mesh.vertices);
    CHECK(mesh.triangles == meshes[i].mesh.triangles);
    H5Gclose(group);
  }
  H5Fclose(in);
}

TEST_CASE("Mesh collections that cannot be written are errors that name the file", "[io]") {
  CHECK_THROWS_WITH(writeMeshes(scratch("no/such/folder/two.h5"), twoMeshes()),
                    Contains("no/such/folder/two.h5"));
}
