// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/hdf5_reader.h"

#include <algorithm>
#include <system_error>

#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"

namespace packmesh {
namespace {

/// Opening a pipe could block forever.
bool isRegular(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(file, ignored);
}

}  // namespace

Hdf5Reader::Hdf5Reader(const std::filesystem::path& file)
    : name_(file.string()),
      file_(isRegular(file) ? H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT) : H5I_INVALID_HID,
            H5Fclose) {
  if (file_.good()) return;
  const bool isHdf5 = isRegular(file) && H5Fis_hdf5(file.c_str()) > 0;
  fail(!isThere(file) ? "no such file"
       : isHdf5       ? "is truncated, damaged, or being written by another program"
                      : "is not an HDF5 file or cannot be read");
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
    fail("attribute '" + std::string(name) + "' of '" + path + "' has an unexpected type");
}

std::string Hdf5Reader::text(const std::string& path, const char* name) const {
  const Hdf5Handle attribute(H5Aopen_by_name(file_, path.c_str(), name, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!attribute.good()) fail("has no attribute '" + std::string(name) + "' of '" + path + "'");
  const Hdf5Handle type(H5Aget_type(attribute), H5Tclose);
  const bool fixed = H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0;
  constexpr std::size_t longest = 1 << 20;
  std::string text(fixed ? std::min(H5Tget_size(type), longest) : 0, '\0');
  if (!fixed || H5Tget_size(type) > longest || H5Aread(attribute, type, text.data()) < 0)
    fail("attribute '" + std::string(name) + "' of '" + path + "' is not text");
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

bool Hdf5Reader::has(const std::string& path) const {
  return H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0;
}

std::array<std::int64_t, 2> Hdf5Reader::size(const std::string& path) const {
  const Hdf5Handle set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set.good()) fail("has no table '" + path + "'");
  const Hdf5Handle space(H5Dget_space(set), H5Sclose), type(H5Dget_type(set), H5Tclose);
  const int rank = H5Sget_simple_extent_ndims(space);
  const H5T_class_t kind = H5Tget_class(type);
  hsize_t size[3] = {0, 1, 1};
  if (rank < 1 || rank > 3 || (kind != H5T_INTEGER && kind != H5T_FLOAT) ||
      H5Sget_simple_extent_dims(space, size, nullptr) < 0)
    fail("'" + path + "' is not a numeric table");
  const hsize_t most = std::filesystem::file_size(name_);  // damaged files can state any size
  for (const hsize_t one : size)
    if (one > most) size[0] = most + 1;
  if (size[0] > most || size[1] * size[2] > most || size[0] * size[1] * size[2] > most)
    fail("is damaged: table '" + path + "' is larger than the file");
  return {static_cast<std::int64_t>(size[0]), static_cast<std::int64_t>(size[1] * size[2])};
}

void Hdf5Reader::requireRows(const std::string& path, int columns, std::int64_t first,
                             std::int64_t count) const {
  const auto found = size(path);
  if (found[1] != columns || first < 0 || count < 0 || first > found[0] || count > found[0] - first)
    fail("table '" + path + "' has " + std::to_string(found[0]) + " x " + std::to_string(found[1]) +
         " numbers; expected " + std::to_string(first + count) + " x " + std::to_string(columns));
}

void Hdf5Reader::readTable(const std::string& path, int columns, std::int64_t first, std::int64_t count,
                           hid_t type, void* to) const {
  if (count == 0) return;
  const Hdf5Handle set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
  const Hdf5Handle space(H5Dget_space(set), H5Sclose), memory(rowsSpace(count, columns), H5Sclose);
  if (!selectRows(space, first, count) || H5Dread(set, type, memory, space, H5P_DEFAULT, to) < 0)
    fail("table '" + path + "' cannot be read: the file is damaged");
}

}  // namespace packmesh
