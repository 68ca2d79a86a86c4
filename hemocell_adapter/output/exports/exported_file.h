// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A file of cells for another program, as texts of single cells.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "packMesh/core/pose.h"

namespace packmesh::hemocell {

/// One cell.
struct ExportedCell {
  int species = 0;
  std::vector<std::int64_t> before;  ///< number of cells of each species before it, all ranks together
  Pose pose;
  Placement placement;  ///< as certified

  /// Sum over the cells before it, for numbering their parts.
  /// @param perCell parts of one cell of each species
  std::int64_t partsBefore(const std::vector<std::int64_t>& perCell) const {
    std::int64_t sum = 0;
    for (std::size_t s = 0; s < before.size(); ++s) sum += before[s] * perCell[s];
    return sum;
  }

  /// Among all cells, from 1 on.
  std::int64_t number() const { return 1 + partsBefore(std::vector<std::int64_t>(before.size(), 1)); }
};

/// A part of a file: a header, then what is written for each cell.
struct ExportedSection {
  std::string head;
  std::function<std::string(const ExportedCell&)> text = {};  ///< empty: there is only the header
  int species = -1;                                           ///< cells of this species only; -1: all
};

struct ExportedFile {
  std::string name;
  std::vector<ExportedSection> sections;
};

}  // namespace packmesh::hemocell
