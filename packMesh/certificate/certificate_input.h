// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What a certificate examines.
#pragma once

#include <functional>
#include <vector>

#include "packMesh/certificate/certificate.h"
#include "packMesh/parallel/threads.h"
#include "packMesh/problem/cell.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

/// Input of the certificate. Holds references only.
struct CertificateInput {
  std::vector<const Shape*> shapes;  ///< Physics::shapes
  std::vector<const Wall*> walls;    ///< per species; nullptr: no wall
  const Container* container = nullptr;
  const std::vector<PlacedCell>* cells = nullptr;
  double requiredGap = 0.0;               ///< pairs with a smaller gap count as overlapping [µm]
  double requiredWallGap = 0.0;           ///< cells closer to their wall count as misplaced [µm]
  std::vector<double> extraWallGap = {};  ///< per species, added to requiredWallGap [µm]; empty: 0
  double largestGap = usualGapOfInterest,
         largestWallGap = usualGapOfInterest;  ///< larger ones are not measured [µm]

  double wallGapOf(int species) const {
    return requiredWallGap + (extraWallGap.empty() ? 0.0 : extraWallGap[species]);
  }
  /// True for the cells to certify; the others, copies of cells certified by other ranks, only occur as
  /// second cell of pairs. nullptr: all.
  const std::vector<bool>* own = nullptr;
  /// Polled by the calling thread between cells; true stops. Empty: never.
  std::function<bool()> stop = {};
  bool upToFirstFault = false;  ///< stop at the first cell with a violation
  Threads threads = {};         ///< that share the work of this rank
};

/// The cells of a packing and what is required of them. References both arguments.
CertificateInput certificateInputOf(const Physics& physics, const std::vector<PlacedCell>& cells,
                                    const Threads& threads = {});

}  // namespace packmesh
