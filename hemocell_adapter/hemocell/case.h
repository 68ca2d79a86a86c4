// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A HemoCell case: its config.xml and its C++ code, or what a running HemoCell has built of them.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/case_source.h"
#include "hemocell_adapter/hemocell/lattice.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh::hemocell {

/// `<domain>`: the data that determine the lattice.
struct Domain {
  double dx = 0.0;                                ///< [µm]
  std::string dxWhere;                            ///< "config.xml:32: <dx>"
  std::optional<std::filesystem::path> geometry;  ///< STL file, relative to the working directory or absolute
  std::string geometryWhere;                      ///< "config.xml:31: <geometry>"
  int refDir = 0, refDirN = 0;                    ///< only with a geometry
  std::optional<std::array<int, 3>> boxNodes;     ///< only without a geometry
  std::optional<int> particleEnvelope;            ///< [nodes]
  std::string particleEnvelopeWhere;              ///< "config.xml:33: <particleEnvelope>"
  std::optional<std::array<int, 3>> smallestBlock;  ///< of a running HemoCell: least nodes along each axis
};

/// A cell type of a running HemoCell.
struct BuiltCell {
  std::string name;
  TriangleMesh mesh;                     ///< the template, centred on its bounding box [µm]
  int minimumDistanceFromSolid = 0;      ///< as HemoCell stores it [µm]
  std::optional<double> hemocellVolume;  ///< `<Volume>` [µm³]
};

/// What a running HemoCell has built, and the program otherwise derives from files and C++ code.
struct RunningSystem {
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

/// A HemoCell case. Made by readCase() from its folder, and by the plug-in from a running HemoCell: then with
/// the running system, without C++ code and geometry, and the working directory is its folder.
struct Case {
  std::filesystem::path file, folder;  ///< config.xml, and where it is
  Domain domain;
  bool hasPreInlet = false;
  std::optional<int> preInletLength;  ///< `<preInlet><parameters><lengthN>` [nodes]
  Request packing;    ///< its contents; relative paths are made relative to the working directory
  CaseSource source;  ///< what the C++ code beside config.xml says
  std::optional<RunningSystem> running;
};

/// Reads config.xml and the C++ code beside it. Unneeded tags outside `<packing>` are ignored, as in
/// HemoCell; the others are read strictly (HemoCell reads a malformed number as 0).
/// @throws InputError with file, line, tag, value and what was expected
Case readCase(const std::filesystem::path& file);

/// Only what config.xml says about packing: its `<packing>` section, read as strictly. For a running
/// HemoCell, which has read the rest.
/// @param text the XML, each tag in the line that it has in the file; the root is `<hemocell>`, or
/// `<Checkpoint>` around it: `<packing>` is not read then, as HemoCell does not write attributes to its
/// checkpoints
/// @throws InputError with file and line
Case packingSectionOf(const std::string& text);

}  // namespace packmesh::hemocell
