// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HDF5 files: read independently by every rank, written by all ranks together. Internal to packMesh.
#pragma once

#include <hdf5.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "packMesh/io/atomic_files.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh {

/// HDF5 prints its errors unless told not to; this suppresses them during its lifetime.
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

/// Owns an HDF5 identifier and closes it on destruction.
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
  /// Gives the identifier away.
  hid_t release() { return std::exchange(id_, H5I_INVALID_HID); }

 private:
  hid_t id_;
  herr_t (*closer_)(hid_t);
};

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

/// An HDF5 file being written. The same content gives the same bytes on any number of ranks.
///
/// HDF5 cannot be left after a failed write: parallel HDF5 waits for ever, and a file that could not be
/// closed ends the program when MPI does. So the first rank alone uses HDF5, on a file in memory that has
/// names, attributes and empty tables. It writes its bytes, and the rows of each rank at the positions of
/// their tables, to the disk itself.
///
/// Collective: all ranks make the same calls. Errors are recorded, not thrown, so that no rank waits for
/// another that has failed.
class Hdf5Writer {
 public:
  /// @param file of which the first rank has begun one
  /// @param userBlock size of the user block [bytes]: 0, or a power of two from 512 on
  Hdf5Writer(AtomicFiles& file, const Communicator& ranks, std::uint64_t userBlock = 0);
  ~Hdf5Writer();
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  void group(const std::string& path);
  void attribute(const std::string& path, const char* name, const std::string& text);
  void attribute(const std::string& path, const char* name, std::int64_t value);
  void attribute(const std::string& path, const char* name, double value);

  /// A table with `columns` columns (one: an array) of `depth` numbers that consists of the rows of all
  /// ranks, in rank order.
  template <class T>
  void table(const std::string& path, int columns, const std::vector<T>& mine, int depth = 1) {
    writeTable(path, static_cast<std::int64_t>(mine.size()) / columns / depth, columns, depth,
               hdf5Type(mine.data()).inFile,
               {reinterpret_cast<const char*>(mine.data()), mine.size() * sizeof(T)});
  }
  /// A table known to all ranks; rank 0 writes it.
  template <class T>
  void commonTable(const std::string& path, int columns, const std::vector<T>& all) {
    table(path, columns, first_ ? all : std::vector<T>());
  }

  /// Completes the file, which the first rank has to end. @throws OutputError on the first rank if there was
  /// an error
  void close();

 private:
  struct Extent {
    std::int64_t begin, end;  ///< positions in the file [bytes]
  };
  void writeAttribute(const std::string& path, const char* name, hid_t type, hid_t inMemory,
                      const void* data);
  void writeTable(const std::string& path, std::int64_t rows, int columns, int depth, hid_t type,
                  std::string_view data);
  std::int64_t placeTable(const std::string& path, std::int64_t rows, int columns, int depth, hid_t type);
  std::int64_t sizeSoFar() const;
  void writeAllButTables();
  void toDisk(std::int64_t position, std::string_view text);
  bool writing() const { return first_ && error_.empty(); }
  void require(bool good, const std::string& otherwise = "cannot be prepared in memory");

  QuietHdf5 quiet_;
  const Communicator& ranks_;
  AtomicFiles& disk_;
  bool first_;
  std::string error_;           ///< the first one
  int memory_ = -1;             ///< descriptor of the file in memory, on the first rank
  Hdf5Handle file_;             ///< the same
  std::vector<Extent> tables_;  ///< on the first rank
};

/// Tables `vertices` (n x 3 doubles [µm]) and `triangles` (m x 3 integers from 0) in a group. All ranks know
/// the mesh.
void writeMesh(Hdf5Writer& out, const std::string& group, const TriangleMesh& mesh);

}  // namespace packmesh
