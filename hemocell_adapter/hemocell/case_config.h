// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A HemoCell case as specified by its config.xml.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "hemocell_adapter/settings/settings.h"

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

struct CaseConfig {
  std::filesystem::path file, folder;
  Domain domain;
  bool hasPreInlet = false;
  std::optional<int> preInletLength;  ///< `<preInlet><parameters><lengthN>` [nodes]
  bool hasPacking = false;            ///< config.xml has a `<packing>` section
  Settings packing;  ///< its contents; relative paths are made relative to the working directory
};

/// Reads config.xml. Unneeded tags outside `<packing>` are ignored, as in HemoCell; the others are read
/// strictly (HemoCell reads a malformed number as 0).
/// @throws InputError with file, line, tag, value and what was expected
CaseConfig readCaseConfig(const std::filesystem::path& file);

/// Only what config.xml says about packing: its `<packing>` section, read as strictly. For a running
/// HemoCell, which has read the rest.
/// @param text the XML, each tag in the line that it has in the file; the root is `<hemocell>`, or
/// `<Checkpoint>` around it: `<packing>` is not read then, as HemoCell does not write attributes to its
/// checkpoints
/// @throws InputError with file and line
CaseConfig packingConfigOf(const std::string& text);

}  // namespace packmesh::hemocell
