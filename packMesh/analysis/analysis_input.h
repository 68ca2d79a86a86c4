// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Input of measurements.
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "packMesh/container/container.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/parallel/threads.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// Species and lumen of a packing. References but for `outside`; identical on all ranks.
struct AnalysisInput {
  std::vector<const Shape*> shapes;  ///< per species
  std::vector<bool> inHematocrit;    ///< per species: true if its volume counts in the hematocrit
  const Container* container = nullptr;
  /// Cells that are not wholly inside the lumen, numbered over all ranks: profiles and local hematocrits
  /// leave them out. A certified packing has none.
  std::set<std::int64_t> outside = {};
  Communicator communicator;
  Threads threads = {};  ///< of this rank
};

}  // namespace packmesh
