// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A cell with what the view of a report shows of it.
#pragma once

#include "packMesh/certificate/certificate.h"

namespace packmesh::hemocell {

/// A cell and the quantities by which it can be coloured.
struct PicturedCell {
  PlacedCell cell;
  double gap = 0.0;              ///< to the nearest other one [µm]
  double localHematocrit = 0.0;  ///< around it
};

}  // namespace packmesh::hemocell
