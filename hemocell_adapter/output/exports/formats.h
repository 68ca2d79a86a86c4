// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The export formats. docs/howto/export.md describes the files and where the other programs'
/// conventions were found.
///
/// Poses turn and move the template that is packed, centred on its bounding box; unless the other program has
/// the template already, it is one of the files. All functions reference the problem.
#pragma once

#include <cstdint>
#include <vector>

#include "hemocell_adapter/output/exports/exported_file.h"
#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// Numbers of cells of each species, all ranks together.
using CellCounts = std::vector<std::int64_t>;

/// A table of positions and quaternions, for scripts.
std::vector<ExportedFile> csvExport(const Problem& problem, const CellCounts& counts);
/// All membranes in one binary STL.
/// @throws InputError if there are more triangles than an STL can have
std::vector<ExportedFile> stlExport(const Problem& problem, const CellCounts& counts);

/// A data file of ellipsoids with the extents of the meshes.
std::vector<ExportedFile> lammpsExport(const Problem& problem, const CellCounts& counts);
/// A data file of vertices, bonded along the edges of the meshes.
/// @throws InputError if there are more than LAMMPS numbers
std::vector<ExportedFile> lammpsMolecularExport(const Problem& problem, const CellCounts& counts);

/// Mirheo's initial conditions of membranes.
std::vector<ExportedFile> mirheoExport(const Problem& problem, const CellCounts& counts);
/// ESPResSo's object-in-fluid cells.
std::vector<ExportedFile> espressoExport(const Problem& problem, const CellCounts& counts);
/// Initial positions of npFEM. @throws InputError unless the templates are npFEM's own, at most one of red
/// cells and one of platelets, in a lumen without periods that lies in its domain
std::vector<ExportedFile> npfemExport(const Problem& problem, const CellCounts& counts);

}  // namespace packmesh::hemocell
