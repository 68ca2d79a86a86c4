// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Placed cells in the formats of other programs.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/scene.h"

namespace packmesh::hemocell {

/// One cell.
struct ExportedCell {
  int species = 0;
  std::int64_t number = 0;  ///< of all cells, from 1 on
  Pose pose;
};

/// A part of a text file: a header, and one line per cell.
struct ExportedSection {
  std::string head;
  std::function<std::string(const ExportedCell&)> line;
  int species = -1;  ///< cells of this species only; -1: all
};

struct ExportedFile {
  std::string name;
  std::vector<ExportedSection> sections;
};

/// The files of a format (one of exportFormats):
/// - csv: `cells.csv`, a line per cell: id, species, x, y, z [µm], qw, qx, qy, qz;
/// - lammps: `cells.lammps`, a data file of ellipsoids (atom_style ellipsoid; read_data), one type per
/// species,
///   with the extents of the meshes; lengths in µm, density 1;
/// - mirheo: `<Cell>.com_q.txt`, a line per cell: x y z qw qx qy qz, as Mirheo's initial conditions want it.
///
/// Quaternions turn HemoCell's template (thin axis y, centred on its bounding box) into the cell.
///
/// References the scene. @param counts of its species, all ranks together
std::vector<ExportedFile> exportedFiles(const std::string& format, const Scene& scene,
                                        const std::vector<std::int64_t>& counts);

}  // namespace packmesh::hemocell
