// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A HemoCell case as its config.xml states it.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "hemocell_adapter/settings/settings.h"

namespace packmesh::hemocell {

/// `<domain>`: what decides the lattice.
struct Domain {
  double dx = 0.0;                                ///< [µm]
  std::string dxWhere;                            ///< "config.xml:32: <dx>"
  std::optional<std::filesystem::path> geometry;  ///< STL, as found from the case folder
  std::string geometryWhere;                      ///< "config.xml:31: <geometry>"
  int refDir = 0, refDirN = 0;                    ///< with a geometry
  std::optional<std::array<int, 3>> boxNodes;     ///< without one
  std::optional<int> particleEnvelope;            ///< [nodes]
  std::string particleEnvelopeWhere;              ///< "config.xml:33: <particleEnvelope>"
};

struct CaseConfig {
  std::filesystem::path file, folder;
  Domain domain;
  bool hasPreInlet = false;
  std::optional<int> preInletLength;  ///< `<preInlet><parameters><lengthN>` [nodes]
  bool hasPacking = false;            ///< there is a `<packing>` section
  Settings packing;  ///< its contents; relative paths have become relative to the working directory
};

/// Reads config.xml. Tags outside `<packing>` that are not needed are ignored, as HemoCell does; the ones
/// that are needed are read strictly (HemoCell reads a malformed number as 0).
/// @throws InputError with file, line, tag, value and what was expected
CaseConfig readCaseConfig(const std::filesystem::path& file);

}  // namespace packmesh::hemocell
