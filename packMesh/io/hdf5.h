// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HDF5 files, written and read by one rank or by all together. Internal to packMesh/io.
#pragma once

#include <hdf5.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh {

/// Something of HDF5's that has to be closed.
class Hdf5Handle {
 public:
  Hdf5Handle(hid_t id, herr_t (*closer)(hid_t)) : id_(id), closer_(closer) {}
  ~Hdf5Handle() { close(); }
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;

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
class QuietHdf5 {
 public:
  QuietHdf5();
  ~QuietHdf5();
  QuietHdf5(const QuietHdf5&) = delete;
  QuietHdf5& operator=(const QuietHdf5&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// The types that files hold.
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
inline Hdf5Type hdf5Type(const std::int32_t*) {
  return {H5T_STD_I32LE, H5T_NATIVE_INT32};
}

/// A file being written. The same content gives the same bytes on any number of ranks.
///
/// All ranks make the same calls. Errors are remembered, not thrown, so that no rank leaves the others
/// waiting: ask good() in the end.
class Hdf5Writer {
 public:
  /// @param userBlock first bytes that are left to others: 0, 512 or another power of two above
  Hdf5Writer(const std::filesystem::path& file, const Communicator& communicator,
             std::uint64_t userBlock = 0);

  void group(const std::string& path);
  void attribute(const std::string& path, const char* name, const std::string& text);
  void attribute(const std::string& path, const char* name, std::int64_t value);
  void attribute(const std::string& path, const char* name, double value);

  /// A table of `rows` x `columns` (one column: an array), of which this rank has rows from `first` on.
  template <class T>
  void table(const std::string& path, std::int64_t rows, int columns, std::int64_t first,
             const std::vector<T>& mine) {
    writeTable(path, rows, columns, first, static_cast<std::int64_t>(mine.size()) / columns,
               hdf5Type(mine.data()), mine.data());
  }
  /// A table that all ranks know: the first one writes it.
  template <class T>
  void table(const std::string& path, int columns, const std::vector<T>& all) {
    const auto rows = static_cast<std::int64_t>(all.size()) / columns;
    writeTable(path, rows, columns, 0, first_ ? rows : 0, hdf5Type(all.data()), all.data());
  }

  /// Closes the file. @return whether all went well on this rank
  bool close();

 private:
  void writeAttribute(const std::string& path, const char* name, hid_t type, hid_t inMemory,
                      const void* data);
  void writeTable(const std::string& path, std::int64_t rows, int columns, std::int64_t first,
                  std::int64_t count, const Hdf5Type& type, const void* data);
  void note(bool good) { good_ = good_ && good; }

  QuietHdf5 quiet_;
  bool first_, alone_, good_ = true;
  Hdf5Handle file_, transfer_;
};

/// Tables `vertices` (n x 3 doubles [µm]) and `triangles` (m x 3 integers from 0 on) in a group. All ranks
/// know the mesh.
void writeMesh(Hdf5Writer& out, const std::string& group, const TriangleMesh& mesh);

/// A file being read, by every rank on its own.
/// @throws InputError naming the file and what is missing or wrong
class Hdf5Reader {
 public:
  explicit Hdf5Reader(const std::filesystem::path& file);

  std::string text(const std::string& path, const char* name) const;
  std::int64_t integer(const std::string& path, const char* name) const;
  double real(const std::string& path, const char* name) const;

  /// Rows and columns. @throws InputError also when the table is not of numbers
  std::array<std::int64_t, 2> size(const std::string& path) const;
  /// Rows [first, first + count) of a table.
  /// @throws InputError also when it has not so many rows or another number of columns
  template <class T>
  std::vector<T> table(const std::string& path, int columns, std::int64_t first, std::int64_t count) const {
    requireRows(path, columns, first, count);
    std::vector<T> rows(static_cast<std::size_t>(count) * columns);
    readTable(path, columns, first, count, hdf5Type(rows.data()).inMemory, rows.data());
    return rows;
  }
  /// All of it.
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
