// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Placed cells in the formats of other programs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/core/pose.h"

namespace packmesh::hemocell {

/// What an export may say of a kind of cell.
struct ExportedSpecies {
  std::string name;
  std::int64_t count = 0;
  Vec3 size = Vec3::Zero();  ///< of the mesh, along its axes [µm]
  double volume = 0.0;       ///< of the mesh [µm³]
};

/// All there is to export, but for the cells.
struct ExportedPacking {
  std::vector<ExportedSpecies> species;
  Box bounds;  ///< of the lumen [µm]
};

/// One cell.
struct ExportedCell {
  int species = 0;
  std::int64_t number = 0;  ///< of all cells, from 1 on
  Pose pose;
};

/// A part of a text file: a head, and a line for each cell that has one.
struct ExportedSection {
  std::string head;
  std::string (*line)(const ExportedPacking&, const ExportedCell&) = nullptr;
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
std::vector<ExportedFile> exportedFiles(const std::string& format, const ExportedPacking& packing);

}  // namespace packmesh::hemocell
