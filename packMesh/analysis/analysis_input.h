// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What packings are measured by.
#pragma once

#include <vector>

#include "packMesh/container/container.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// Kinds of cells and the lumen they are in. References; the same on all ranks.
struct AnalysisInput {
  std::vector<const Shape*> shapes;  ///< per species
  std::vector<bool> inHematocrit;    ///< per species: whether its volume is part of the hematocrit
  const Container* container = nullptr;
  Communicator communicator;
};

}  // namespace packmesh
