// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A case as a running HemoCell has built it: what the program otherwise derives from files and C++
/// code.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/case_config.h"
#include "hemocell_adapter/hemocell/lattice.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh::hemocell {

/// A cell type of the running HemoCell.
struct BuiltCell {
  std::string name;
  TriangleMesh mesh;                     ///< the template, centred on its bounding box [µm]
  int minimumDistanceFromSolid = 0;      ///< as HemoCell stores it [µm]
  std::optional<double> hemocellVolume;  ///< `<Volume>` [µm³]
};

struct RunningCase {
  /// Its `<packing>` section, particleEnvelope and spacing; no geometry. The working directory is its folder.
  CaseConfig config;
  std::vector<BuiltCell> cells;
  std::shared_ptr<const Lattice> lattice;  ///< nodes that no block covers are solid
  std::array<bool, 3> periodic{};
  bool isPreInlet = false;  ///< the lattice is that of the pre-inlet

  /// nullptr if there is none of this name.
  const BuiltCell* cell(const std::string& name) const {
    for (const BuiltCell& one : cells)
      if (one.name == name) return &one;
    return nullptr;
  }
};

}  // namespace packmesh::hemocell
