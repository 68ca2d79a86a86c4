// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Numeric tables in HDF5 files. Internal to packMesh.
#pragma once

#include <hdf5.h>

#include <cstdint>

namespace packmesh {

/// Types of numbers in files.
struct Hdf5Type {
  hid_t inFile, inMemory;
};
inline Hdf5Type hdf5Type(const double*) {
  return {H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE};
}
inline Hdf5Type hdf5Type(const float*) {
  return {H5T_IEEE_F32LE, H5T_NATIVE_FLOAT};
}
inline Hdf5Type hdf5Type(const std::int64_t*) {
  return {H5T_STD_I64LE, H5T_NATIVE_INT64};
}
inline Hdf5Type hdf5Type(const std::uint8_t*) {
  return {H5T_STD_U8LE, H5T_NATIVE_UINT8};
}
inline Hdf5Type hdf5Type(const std::int32_t*) {
  return {H5T_STD_I32LE, H5T_NATIVE_INT32};
}

/// Dataspace of a table with `rows` rows; an array with one column.
/// @param depth numbers in each column; more than one: the table has a third dimension
inline hid_t rowsSpace(std::int64_t rows, int columns, int depth = 1) {
  const hsize_t size[3] = {static_cast<hsize_t>(rows), static_cast<hsize_t>(columns),
                           static_cast<hsize_t>(depth)};
  return H5Screate_simple(depth > 1 ? 3 : columns == 1 ? 1 : 2, size, nullptr);
}

/// @return true if rows [first, first + count) could be selected
inline bool selectRows(hid_t space, std::int64_t first, std::int64_t count) {
  const hsize_t from[3] = {static_cast<hsize_t>(first), 0, 0};
  hsize_t size[3] = {};
  if (H5Sget_simple_extent_dims(space, size, nullptr) < 0) return false;
  size[0] = static_cast<hsize_t>(count);
  return (count > 0 ? H5Sselect_hyperslab(space, H5S_SELECT_SET, from, nullptr, size, nullptr)
                    : H5Sselect_none(space)) >= 0;
}

}  // namespace packmesh
