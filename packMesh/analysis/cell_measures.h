// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Measurements of individual cells.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

#include "packMesh/certificate/certificate.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

/// Measurements per cell; empty: not measured. See measureCells(). All columns have the same length.
struct CellMeasures {
  std::vector<double> gap;  ///< to the nearest other membrane, at most CertificateInput::largestGap [µm]
  std::vector<double> localHematocrit;  ///< volume fraction of red cells around it

  /// A column, by its name in files.
  struct Column {
    const char* name;
    std::vector<double> CellMeasures::*values;
  };
  static const std::array<Column, 2> columns;

  std::size_t size() const;  ///< number of cells of which all numbers are known
  void resize(std::size_t cells);
};

inline constexpr std::array<CellMeasures::Column, 2> CellMeasures::columns = {
    {{"gap", &CellMeasures::gap}, {"local_hematocrit", &CellMeasures::localHematocrit}}};

/// The numbers of one cell, for messages between ranks.
using MeasuresOfCell = std::array<double, CellMeasures::columns.size()>;
MeasuresOfCell measuresOfCell(const CellMeasures& measures, std::size_t cell);
void setMeasuresOfCell(CellMeasures& measures, std::size_t cell, const MeasuresOfCell& of);

/// Measures this rank's own cells, in their order among all cells of `input`. Collective.
///
/// The gap is the distance between the mesh of a cell and the nearest other mesh, periodic images included:
/// the same number that the certificate measures, 0 for overlapping cells. Its bits do not depend on the
/// rank, provided cells are in the same order everywhere. The local hematocrit is the volume fraction of red
/// cells (Species::inHematocrit) in the part of the lumen around the cell: in the boxes of about 10 µm
/// that contain its volume.
/// @param input of the same physics; full-size cells of this rank and copies of all cells within largestGap
/// of them, sorted by number
/// @param leftOut per cell of `input`, or empty: cells whose volume does not count in local hematocrits
CellMeasures measureCells(const Physics& physics, const Execution& execution, const CertificateInput& input,
                          const std::vector<bool>& leftOut = {});

/// measureCells() for cells distributed arbitrarily over the ranks, as pack() returns them: each rank gets
/// the measurements of its own cells. The numbers do not depend on the distribution. Collective.
/// @param own full-size cells of this rank; numbered globally in rank order
/// @param outside cells that are not wholly inside the lumen, numbered over all ranks, the same on all:
/// local hematocrits leave them out. A certified packing has none
/// @param largestGap larger gaps are not measured [µm]
CellMeasures measureShare(const Physics& physics, const Execution& execution,
                          const std::vector<PlacedCell>& own, const std::set<std::int64_t>& outside = {},
                          double largestGap = usualGapOfInterest);

}  // namespace packmesh
