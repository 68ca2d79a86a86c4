// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/hdf5_writer.h"

#include <mpi.h>

namespace packmesh {
namespace {

hid_t openToWrite(const std::filesystem::path& file, const Communicator& communicator,
                  std::uint64_t userBlock) {
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  if (!communicator.alone() &&
      H5Pset_fapl_mpio(access, *static_cast<const MPI_Comm*>(communicator.mpi()), MPI_INFO_NULL) < 0)
    return -1;
  const Hdf5Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation, false);
  if (H5Pset_userblock(creation, userBlock) < 0) return -1;
  return H5Fcreate(file.c_str(), H5F_ACC_TRUNC, creation, access);
}

hid_t collectiveTransfer(const Communicator& communicator) {
  const hid_t transfer = H5Pcreate(H5P_DATASET_XFER);
  if (!communicator.alone()) H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE);
  return transfer;
}

}  // namespace

Hdf5Writer::Hdf5Writer(const std::filesystem::path& file, const Communicator& communicator,
                       std::uint64_t userBlock)
    : first_(communicator.rank() == 0),
      alone_(communicator.alone()),
      file_(openToWrite(file, communicator, userBlock), H5Fclose),
      transfer_(collectiveTransfer(communicator), H5Pclose) {
  note(file_.good());
}

void Hdf5Writer::group(const std::string& path) {
  const Hdf5Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation, false);
  const Hdf5Handle group(H5Gcreate2(file_, path.c_str(), H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose);
  note(group.good());
}

void Hdf5Writer::attribute(const std::string& path, const char* name, const std::string& text) {
  const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  note(H5Tset_size(type, text.size() + 1) >= 0 && H5Tset_cset(type, H5T_CSET_UTF8) >= 0);
  writeAttribute(path, name, type, type, text.c_str());
}
void Hdf5Writer::attribute(const std::string& path, const char* name, std::int64_t value) {
  writeAttribute(path, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
}
void Hdf5Writer::attribute(const std::string& path, const char* name, double value) {
  writeAttribute(path, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

void Hdf5Writer::writeAttribute(const std::string& path, const char* name, hid_t type, hid_t inMemory,
                                const void* data) {
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Handle attribute(
      H5Acreate_by_name(file_, path.c_str(), name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Aclose);
  note(attribute.good() && H5Awrite(attribute, inMemory, data) >= 0);
}

void Hdf5Writer::writeTable(const std::string& path, std::int64_t rows, int columns, std::int64_t first,
                            std::int64_t count, const Hdf5Type& type, const void* data) {
  const Hdf5Handle space(rowsSpace(rows, columns), H5Sclose), memory(rowsSpace(count, columns), H5Sclose);
  const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation, false);
  H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY);  // as with several ranks: same file offsets
  H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER);
  const Hdf5Handle set(
      H5Dcreate2(file_, path.c_str(), type.inFile, space, H5P_DEFAULT, creation, H5P_DEFAULT), H5Dclose);
  note(set.good());
  if (rows == 0 || !set.good()) return;
  note(selectRows(space, first, count, columns) && selectRows(memory, 0, count, columns) &&
       H5Dwrite(set, type.inMemory, memory, space, transfer_, data) >= 0);
}

bool Hdf5Writer::close() {
  note(file_.good() && H5Fflush(file_, H5F_SCOPE_GLOBAL) >= 0);
  note(file_.close());
  return good_;
}

void writeMesh(Hdf5Writer& out, const std::string& group, const TriangleMesh& mesh) {
  std::vector<double> vertices;
  for (const Vec3& v : mesh.vertices) vertices.insert(vertices.end(), v.data(), v.data() + 3);
  std::vector<std::int32_t> triangles;
  for (const Triangle& t : mesh.triangles) triangles.insert(triangles.end(), {t[0], t[1], t[2]});
  out.table(group + "/vertices", 3, vertices);
  out.table(group + "/triangles", 3, triangles);
}

}  // namespace packmesh
