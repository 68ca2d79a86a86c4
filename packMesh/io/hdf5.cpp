// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/hdf5.h"

#include <mpi.h>
#include <algorithm>
#include <system_error>

#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"

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

hid_t rowsSpace(std::int64_t rows, int columns) {
  const hsize_t size[2] = {static_cast<hsize_t>(rows), static_cast<hsize_t>(columns)};
  return H5Screate_simple(columns == 1 ? 1 : 2, size, nullptr);
}

bool selectRows(hid_t space, std::int64_t first, std::int64_t count, int columns) {
  const hsize_t from[2] = {static_cast<hsize_t>(first), 0};
  const hsize_t size[2] = {static_cast<hsize_t>(count), static_cast<hsize_t>(columns)};
  return (count > 0 ? H5Sselect_hyperslab(space, H5S_SELECT_SET, from, nullptr, size, nullptr)
                    : H5Sselect_none(space)) >= 0;
}

/// A pipe would be waited for without end.
bool isRegular(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(file, ignored);
}

}  // namespace

QuietHdf5::QuietHdf5() {
  H5dont_atexit();  // files are closed by then; damaged ones make it complain
  H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}
QuietHdf5::~QuietHdf5() {
  H5Eset_auto2(H5E_DEFAULT, function_, data_);
}

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
  H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY);  // as with several ranks, so that places are the same
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

Hdf5Reader::Hdf5Reader(const std::filesystem::path& file)
    : name_(file.string()),
      file_(isRegular(file) ? H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT) : H5I_INVALID_HID,
            H5Fclose) {
  if (file_.good()) return;
  const bool isHdf5 = isRegular(file) && H5Fis_hdf5(file.c_str()) > 0;
  fail(!isThere(file) ? "no such file"
       : isHdf5       ? "is truncated or damaged, or another program writes it"
                      : "is not an HDF5 file, or cannot be read");
}

void Hdf5Reader::fail(const std::string& what) const {
  throw InputError(name_ + ": " + what);
}

void Hdf5Reader::readAttribute(const std::string& path, const char* name, H5T_class_t kind, hid_t type,
                               void* to) const {
  const Hdf5Handle attribute(H5Aopen_by_name(file_, path.c_str(), name, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!attribute.good()) fail("has no attribute '" + std::string(name) + "' of '" + path + "'");
  const Hdf5Handle found(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  if (H5Tget_class(found) != kind || H5Sget_simple_extent_npoints(space) != 1 ||
      H5Aread(attribute, type, to) < 0)
    fail("attribute '" + std::string(name) + "' of '" + path + "' is not what it should be");
}

std::string Hdf5Reader::text(const std::string& path, const char* name) const {
  const Hdf5Handle attribute(H5Aopen_by_name(file_, path.c_str(), name, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!attribute.good()) fail("has no attribute '" + std::string(name) + "' of '" + path + "'");
  const Hdf5Handle type(H5Aget_type(attribute), H5Tclose);
  const bool fixed = H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0;
  constexpr std::size_t longest = 1 << 20;
  std::string text(fixed ? std::min(H5Tget_size(type), longest) : 0, '\0');
  if (!fixed || H5Tget_size(type) > longest || H5Aread(attribute, type, text.data()) < 0)
    fail("attribute '" + std::string(name) + "' of '" + path + "' is not a text");
  return text.c_str();
}
std::int64_t Hdf5Reader::integer(const std::string& path, const char* name) const {
  std::int64_t value = 0;
  readAttribute(path, name, H5T_INTEGER, H5T_NATIVE_INT64, &value);
  return value;
}
double Hdf5Reader::real(const std::string& path, const char* name) const {
  double value = 0.0;
  readAttribute(path, name, H5T_FLOAT, H5T_NATIVE_DOUBLE, &value);
  return value;
}

std::array<std::int64_t, 2> Hdf5Reader::size(const std::string& path) const {
  const Hdf5Handle set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set.good()) fail("has no table '" + path + "'");
  const Hdf5Handle space(H5Dget_space(set), H5Sclose), type(H5Dget_type(set), H5Tclose);
  const int rank = H5Sget_simple_extent_ndims(space);
  const H5T_class_t kind = H5Tget_class(type);
  hsize_t size[2] = {0, 1};
  if (rank < 1 || rank > 2 || (kind != H5T_INTEGER && kind != H5T_FLOAT) ||
      H5Sget_simple_extent_dims(space, size, nullptr) < 0)
    fail("'" + path + "' is not a table of numbers");
  const hsize_t most = std::filesystem::file_size(name_);  // a damaged file can claim anything
  if (size[0] > most || size[1] > most || size[0] * size[1] > most)
    fail("is damaged: table '" + path + "' is larger than the file");
  return {static_cast<std::int64_t>(size[0]), static_cast<std::int64_t>(size[1])};
}

void Hdf5Reader::requireRows(const std::string& path, int columns, std::int64_t first,
                             std::int64_t count) const {
  const auto found = size(path);
  if (found[1] != columns || first < 0 || count < 0 || first > found[0] || count > found[0] - first)
    fail("table '" + path + "' has " + std::to_string(found[0]) + " x " + std::to_string(found[1]) +
         " numbers, not the " + std::to_string(first + count) + " x " + std::to_string(columns) +
         " expected");
}

void Hdf5Reader::readTable(const std::string& path, int columns, std::int64_t first, std::int64_t count,
                           hid_t type, void* to) const {
  if (count == 0) return;
  const Hdf5Handle set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
  const Hdf5Handle space(H5Dget_space(set), H5Sclose), memory(rowsSpace(count, columns), H5Sclose);
  if (!selectRows(space, first, count, columns) || H5Dread(set, type, memory, space, H5P_DEFAULT, to) < 0)
    fail("table '" + path + "' cannot be read: the file is damaged");
}

}  // namespace packmesh
