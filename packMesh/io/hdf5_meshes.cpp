// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/hdf5_meshes.h"

#include <hdf5.h>

namespace packmesh {
namespace {

/// Something of HDF5's that has to be closed.
class Handle {
 public:
  Handle(hid_t id, herr_t (*closer)(hid_t)) : id_(id), closer_(closer) {}
  ~Handle() { close(); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  operator hid_t() const { return id_; }
  bool good() const { return id_ >= 0; }
  bool close() {
    const bool closed = id_ < 0 || closer_(id_) >= 0;
    id_ = -1;
    return closed;
  }

 private:
  hid_t id_;
  herr_t (*closer_)(hid_t);
};

/// HDF5 prints its errors unless told not to.
class Quiet {
 public:
  Quiet() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Quiet() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

bool writeText(hid_t at, const char* name, const std::string& text) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
  if (H5Tset_size(type, text.size() + 1) < 0 || H5Tset_cset(type, H5T_CSET_UTF8) < 0) return false;
  Handle attribute(H5Acreate2(at, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute.good() && H5Awrite(attribute, type, text.c_str()) >= 0;
}

/// Rows of three.
bool writeRows(hid_t at, const char* name, std::size_t rows, hid_t inFile, hid_t inMemory, const void* data) {
  const hsize_t size[2] = {rows, 3};
  Handle space(H5Screate_simple(2, size, nullptr), H5Sclose);
  Handle set(H5Dcreate2(at, name, inFile, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose);
  return set.good() && (rows == 0 || H5Dwrite(set, inMemory, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0);
}

bool writeOne(hid_t at, const std::string& number, const NamedMesh& named) {
  Handle group(H5Gcreate2(at, number.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  const TriangleMesh& mesh = named.mesh;
  return group.good() && writeText(group, "name", named.name) &&
         writeRows(group, "vertices", mesh.vertices.size(), H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                   mesh.vertices.data()) &&
         writeRows(group, "triangles", mesh.triangles.size(), H5T_STD_I32LE, H5T_NATIVE_INT,
                   mesh.triangles.data());
}

}  // namespace

bool writeHdf5(const std::filesystem::path& file, const std::vector<NamedMesh>& meshes) {
  const Quiet quiet;
  Handle out(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
  if (!out.good() || !writeText(out, "unit", "µm")) return false;
  Handle group(H5Gcreate2(out, "meshes", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  if (!group.good()) return false;
  for (std::size_t i = 0; i < meshes.size(); ++i)
    if (!writeOne(group, std::to_string(i), meshes[i])) return false;
  return group.close() && out.close();
}

}  // namespace packmesh
