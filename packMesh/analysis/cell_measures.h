// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What is measured of every cell of a packing, for people to look at.
#pragma once

#include <vector>

#include "packMesh/analysis/analysis_input.h"
#include "packMesh/certificate/certificate.h"

namespace packmesh {

/// Gaps are measured up to this [µm], as far as ranks are sure to have copies; cells that are further from
/// all others have it.
constexpr double farthestGap = gapOfInterest;

/// Of cells, for people to look at; empty: not measured. See measureCells().
struct CellMeasures {
  std::vector<double> gap;              ///< to the nearest other membrane [µm]
  std::vector<double> localHematocrit;  ///< volume fraction of red cells around it
};

/// Measures of a rank's own cells, in their order among all cells of `input`. All ranks call.
///
/// The gap is the distance between the meshes of a cell and of the nearest other one, images included: the
/// same number that the certificate measures, 0 where they meet. Its bits do not depend on who measures, as
/// long as cells are in the same order everywhere. The local hematocrit is the volume fraction of red cells
/// (AnalysisInput::inHematocrit) in the part of the lumen around the cell: in those boxes of about 10 µm in
/// which its volume lies.
/// @param input the same shapes and container; cells of full size, those of this rank and copies of others
/// around them, ordered by number
CellMeasures measureCells(const AnalysisInput& analysis, const CertificateInput& input);

}  // namespace packmesh
