// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HDF5 files to which all ranks contribute. Internal to packMesh.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "packMesh/io/atomic_files.h"
#include "packMesh/io/hdf5_handle.h"
#include "packMesh/io/hdf5_table.h"
#include "packMesh/io/quiet_hdf5.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh {

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
