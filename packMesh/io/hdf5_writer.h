// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HDF5 files, written by one rank or collectively. Internal to packMesh.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/io/hdf5_handle.h"
#include "packMesh/io/hdf5_table.h"
#include "packMesh/io/quiet_hdf5.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh {

/// An HDF5 file being written. The same content gives the same bytes on any number of ranks.
///
/// Collective: all ranks make the same calls. Errors are recorded, not thrown, so that no rank blocks the
/// others; check good() at the end.
class Hdf5Writer {
 public:
  /// @param userBlock size of the user block [bytes]: 0, or a power of two from 512 on
  Hdf5Writer(const std::filesystem::path& file, const Communicator& communicator,
             std::uint64_t userBlock = 0);

  void group(const std::string& path);
  void attribute(const std::string& path, const char* name, const std::string& text);
  void attribute(const std::string& path, const char* name, std::int64_t value);
  void attribute(const std::string& path, const char* name, double value);

  /// A table of `rows` x `columns` (one column: an array); this rank has the rows from `first` on.
  template <class T>
  void table(const std::string& path, std::int64_t rows, int columns, std::int64_t first,
             const std::vector<T>& mine) {
    writeTable(path, rows, columns, first, static_cast<std::int64_t>(mine.size()) / columns,
               hdf5Type(mine.data()), mine.data());
  }
  /// A table known to all ranks; rank 0 writes it.
  template <class T>
  void table(const std::string& path, int columns, const std::vector<T>& all) {
    const auto rows = static_cast<std::int64_t>(all.size()) / columns;
    writeTable(path, rows, columns, 0, first_ ? rows : 0, hdf5Type(all.data()), all.data());
  }

  /// Closes the file. @return true if there was no error on this rank
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

/// Tables `vertices` (n x 3 doubles [µm]) and `triangles` (m x 3 integers from 0) in a group. All ranks know
/// the mesh.
void writeMesh(Hdf5Writer& out, const std::string& group, const TriangleMesh& mesh);

}  // namespace packmesh
