// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The cells of a packing as tables in an HDF5 file, for programs that show or convert them;
/// docs/reference/state.md describes the format. State files have the same tables.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "packMesh/analysis/cell_measures.h"
#include "packMesh/certificate/certificate.h"
#include "packMesh/container/container.h"
#include "packMesh/core/pose.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh {

class Hdf5Writer;

/// Numbers of this rank's cells, `width` of each.
struct CellColumn {
  std::string name;
  int width = 1;
  std::vector<double> values;
};

/// References meshes, lumen and certificate.
struct PackingTables {
  struct Kind {
    std::string name;
    const TriangleMesh* mesh = nullptr;
    std::int64_t count = 0;  ///< cells, of all ranks
    bool red = true;         ///< its volume counts in the hematocrit
    /// Of a mesh that was read from a file and is packed as it is: the point of the file that is the origin
    /// of the mesh [µm]; otherwise empty, and why there is none: "is turned or scaled".
    std::optional<Vec3> originInFile = {};
    std::string unlikeFile = {};
  };
  std::vector<Kind> kinds;           ///< the same on all ranks
  const Container* lumen = nullptr;  ///< nullptr: is not written
  /// Cells of this rank, preceded by those of lower ranks.
  std::vector<std::int32_t> kind;  ///< indices into `kinds`
  std::vector<Pose> poses;
  std::vector<CellColumn> columns;
  /// Of those with meshes of their own, in the order and frame of the template [µm]; nullptr for the others.
  /// Empty: none.
  std::vector<const std::vector<Vec3>*> vertices = {};
  const Certificate* certificate = nullptr;  ///< of which the faults are written; nullptr: none
};

/// What wrote a file, as it states.
std::string writer();

/// Measures as columns; NaN where they are not known. @param cells of this rank
std::vector<CellColumn> columnsOf(const CellMeasures& measures, std::size_t cells);

/// The group of a species in files.
std::string pathOfSpecies(std::size_t species);

/// Rows of the cells in the tables of membranes.
inline constexpr const char* membraneRows = "/cells/membrane";

/// Writes the vertices of the cells that have meshes of their own, `/species/<s>/membranes`, and the row of
/// each cell in them, `/cells/membrane`; nothing if there are no such cells. All ranks call.
/// @param species numbers of species in the file, and those of this rank's cells, which those of lower ranks
/// precede
/// @param verticesOf of one of them, in the order and frame of the template [µm]; nullptr: it has that of the
/// template
void writeMembranes(Hdf5Writer& out, std::size_t species, const std::vector<std::int32_t>& speciesOfCells,
                    const std::function<const std::vector<Vec3>*(std::size_t)>& verticesOf,
                    const Communicator& ranks);

/// Group `/lumen`: its box, and its surface if it has a wall. All ranks call.
void writeLumen(Hdf5Writer& out, const Container& lumen);
/// Tables in the group `/cells`. All ranks call.
void writeColumns(Hdf5Writer& out, const std::vector<CellColumn>& columns);

/// Writes the file under a temporary name beside `file`. All ranks call.
/// @return on the first rank: to be ended and committed, or to be removed with the object
/// @throws OutputError on all ranks if that fails
std::unique_ptr<AtomicFiles> writtenPacking(const std::filesystem::path& file, const PackingTables& tables,
                                            const Communicator& ranks);

/// Writes `file` completely or not at all. The same cells give the same bytes on any number of ranks. All
/// ranks call.
/// @throws OutputError on all ranks if that fails
void writePacking(const std::filesystem::path& file, const PackingTables& tables, const Communicator& ranks);

}  // namespace packmesh
