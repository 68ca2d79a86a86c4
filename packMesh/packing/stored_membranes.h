// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Meshes of deformed cells in files. Internal to packMesh/packing.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "packMesh/core/vector.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh {

class Hdf5Reader;
class Hdf5Writer;

/// The group of a species in files.
std::string pathOfSpecies(std::size_t species);

/// Writes the vertices of the cells that have meshes of their own, `/species/<s>/membranes`, and the row of
/// each cell in them, `/cells/membrane`; nothing if there are no such cells. All ranks call.
/// @param species numbers of species in the file, and those of this rank's cells, which those of lower ranks
/// precede
/// @param verticesOf of one of them, in the order and frame of the template [µm]; nullptr: it has that of the
/// template
void writeMembranes(Hdf5Writer& out, std::size_t species, const std::vector<std::int32_t>& speciesOfCells,
                    const std::function<const std::vector<Vec3>*(std::size_t)>& verticesOf,
                    const Communicator& ranks);

/// Vertices of the cells of a part of a file that have meshes of their own, in the frame of their template.
class StoredMembranes {
 public:
  static bool areIn(const Hdf5Reader& in);
  /// Pre: areIn(in) @param species, first, count cells of the file that will be asked for
  StoredMembranes(const Hdf5Reader& in, const std::vector<std::int32_t>& species, std::int64_t first,
                  std::int64_t count);

  /// Of a cell, counted from the first one [µm]; empty: it has the mesh of its template.
  std::vector<Vec3> of(std::int64_t cell) const;

 private:
  struct Rows {
    std::int64_t first = 0, width = 0;  ///< numbers in a row
    std::vector<double> values;
  };
  std::vector<std::int32_t> species_;
  std::vector<std::int32_t> row_;
  std::vector<Rows> rows_;  ///< by species of the file
};

}  // namespace packmesh
