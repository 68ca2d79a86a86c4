// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The cells of a state file, whatever problem they were packed for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/packing/state_file.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/problem/cell.h"

namespace packmesh {

/// Cells with their kinds, which Cell::species counts.
struct StateCells {
  /// A kind of cell. Parts of it that were packed under different constraints are one.
  struct Kind {
    std::string name;
    TriangleMesh mesh;       ///< the template [µm]
    std::int64_t count = 0;  ///< cells in the file
  };
  std::vector<Kind> species;
  Box box;                     ///< of the lumen [µm]
  Vec3 period = Vec3::Zero();  ///< 0: not periodic [µm]
  std::vector<Cell> cells;     ///< this rank's share, at full size, in the order of the file
  StateRecord record;
  bool certified = false;  ///< they are those of a finished packing
  bool deformed = false;   ///< some have meshes of their own
};

/// Reads the cells; every rank a part of its own. All ranks call.
/// @param withMeshes also the vertices of those that have meshes of their own
/// @throws InputError on all ranks if the file is not a state, of a version that is not read, damaged, or of
/// cells that still grow
StateCells readStateCells(const std::filesystem::path& file, const Communicator& ranks,
                          bool withMeshes = true);

}  // namespace packmesh
