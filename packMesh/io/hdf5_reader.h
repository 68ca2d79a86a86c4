// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HDF5 files, read independently by every rank. Internal to packMesh.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/io/hdf5_handle.h"
#include "packMesh/io/hdf5_table.h"
#include "packMesh/io/quiet_hdf5.h"

namespace packmesh {

/// An HDF5 file opened for reading, independently by every rank.
/// @throws InputError naming the file and what is missing or invalid
class Hdf5Reader {
 public:
  explicit Hdf5Reader(const std::filesystem::path& file);

  std::string text(const std::string& path, const char* name) const;
  std::int64_t integer(const std::string& path, const char* name) const;
  double real(const std::string& path, const char* name) const;

  bool has(const std::string& path) const;  ///< Pre: the group of the path exists
  /// Numbers of rows and columns; with a third dimension, of the numbers in a row. @throws InputError also if
  /// the table is not numeric
  std::array<std::int64_t, 2> size(const std::string& path) const;
  /// Rows [first, first + count) of a table.
  /// @throws InputError also if it has fewer rows or another number of columns
  template <class T>
  std::vector<T> table(const std::string& path, int columns, std::int64_t first, std::int64_t count) const {
    requireRows(path, columns, first, count);
    std::vector<T> rows(static_cast<std::size_t>(count) * columns);
    readTable(path, columns, first, count, hdf5Type(rows.data()).inMemory, rows.data());
    return rows;
  }
  /// All rows of a table.
  template <class T>
  std::vector<T> table(const std::string& path, int columns) const {
    return table<T>(path, columns, 0, size(path)[0]);
  }

  [[noreturn]] void fail(const std::string& what) const;

 private:
  void readAttribute(const std::string& path, const char* name, H5T_class_t kind, hid_t type, void* to) const;
  void requireRows(const std::string& path, int columns, std::int64_t first, std::int64_t count) const;
  void readTable(const std::string& path, int columns, std::int64_t first, std::int64_t count, hid_t type,
                 void* to) const;

  QuietHdf5 quiet_;
  std::string name_;
  Hdf5Handle file_;
};

}  // namespace packmesh
