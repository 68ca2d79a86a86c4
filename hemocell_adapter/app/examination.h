// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The exact test of existing cells.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/scene.h"
#include "packMesh/certificate/certificate.h"

namespace packmesh::hemocell {

/// The cells of all files, and the origin of each.
struct FoundCells {
  std::vector<PlacedCell> cells;
  std::vector<Pose> poses;
  std::vector<std::int64_t> lineNumber;  ///< in its .pos file
};

/// Reads the .pos files of a scene that is to be checked, or the cells of its states. @throws InputError
FoundCells readCells(const Scene& scene);

/// What was found in cells: whether they overlap, are in the lumen, and are kept by HemoCell.
struct Examination {
  Certificate certificate;
  std::vector<std::optional<std::string>> violations;  ///< HemoCell's, per cell
  std::vector<std::int64_t> kept;                      ///< indices of the cells that HemoCell keeps
  bool droppedIsFault = false;                         ///< whether HemoCell is to keep all

  bool clean() const { return certificate.clean() && (!droppedIsFault || kept.size() == violations.size()); }
};

/// Tests cells against the clearances that the scene demands.
Examination examine(const Scene& scene, const std::vector<PlacedCell>& cells);

}  // namespace packmesh::hemocell
