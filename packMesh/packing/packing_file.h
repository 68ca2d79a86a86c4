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
#include "packMesh/container/container.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

/// Every rank calls `work`, which reads `file` and does not communicate. Collective.
/// @throws InputError on all ranks if it does on one
void readTogether(const std::filesystem::path& file, const Communicator& ranks,
                  const std::function<void()>& work);

class Hdf5Writer;

/// Every rank does `work`, which may communicate. Collective.
/// @throws OutputError on all ranks if it does on one
void writeTogether(const Communicator& ranks, const std::function<void()>& work);

/// Writes an HDF5 file; every rank calls `content` with the same file. Collective.
/// @param userBlock see Hdf5Writer
/// @return on the first rank the file, complete under its temporary name: to be ended and committed, or to be
/// removed with the object
/// @throws OutputError on all ranks
std::unique_ptr<AtomicFiles> writtenHdf5(const std::filesystem::path& file, const Communicator& ranks,
                                         std::uint64_t userBlock,
                                         const std::function<void(Hdf5Writer&)>& content);

/// Gives a file that was written under a temporary name its own. All ranks call.
/// @throws OutputError on all ranks if that fails
void commitTogether(std::unique_ptr<AtomicFiles> files, const Communicator& ranks);

/// A mesh and its name.
struct NamedMesh {
  std::string name;
  TriangleMesh mesh;
  std::string kind = {};  ///< what it is, for the programs that read the file
};

/// Writes all meshes to one file: a group /meshes/<number> per mesh, with `vertices` (n x 3 doubles [µm]),
/// `triangles` (m x 3 integers from 0, counter-clockwise seen from outside) and the attributes `name` and
/// `kind`; the file's attribute `unit` is "µm".
/// @throws OutputError if the file cannot be written
void writeMeshes(const std::filesystem::path& file, const std::vector<NamedMesh>& meshes);

/// Numbers of this rank's cells, `width` of each.
struct CellColumn {
  std::string name;
  int width = 1;
  std::vector<double> values;
};

/// What a template is to the file from which it was read.
struct TemplateSource {
  /// Of a mesh that is packed as it is: the point of the file that is the origin of the mesh [µm]; otherwise
  /// empty, and why there is none: "is turned or scaled".
  std::optional<Vec3> originInFile = {};
  std::string unlikeFile = {};
};

/// What a file has beside the cells of a packing.
struct PackingDetails {
  std::vector<TemplateSource> templates = {};  ///< of each species; empty: not known
  std::vector<CellColumn> columns = {};
  bool lumen = false;  ///< also the lumen
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

/// Writes the cells, as their placements say, and the faults of the certificate, under a temporary name
/// beside `file`; the same cells give the same bytes on any number of ranks. All ranks call.
/// @param physics to whose species and shapes the cells refer; it has the numbers of cells of all ranks
/// @param packing cells of this rank, which those of lower ranks precede
/// @return on the first rank: for commitTogether(), or to be removed with the object
/// @throws OutputError on all ranks if that fails
std::unique_ptr<AtomicFiles> writtenPacking(const std::filesystem::path& file, const Physics& physics,
                                            const PackingResult& packing, const PackingDetails& details,
                                            const Communicator& ranks);

}  // namespace packmesh
