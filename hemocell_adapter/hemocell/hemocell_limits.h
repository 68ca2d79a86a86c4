// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Limits of HemoCell that require changes of the case.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/case_config.h"
#include "hemocell_adapter/hemocell/case_source.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh::hemocell {

/// HemoCell numbers the periodic images of cells and stops if these numbers could overflow: with its default
/// limits, above 212,622 cells.
/// @param calls calls of setSystemPeriodicityLimit in the case
/// @return the required addition to the case's C++ code; empty if the number of cells is possible
std::optional<std::string> cellNumberWarning(std::int64_t cells, const std::vector<PeriodicityCall>& calls);

/// HemoCell knows the vertices of a cell only within `<particleEnvelope>` of the block that contains its
/// centre.
/// @return the required value; empty if the present one is sufficient for this cell at rest, or is not given
std::optional<std::string> envelopeWarning(const std::string& cell, const TriangleMesh& mesh,
                                           const Domain& domain);

/// Largest distance between two vertices [unit of the mesh].
double longestExtent(const TriangleMesh& mesh);

}  // namespace packmesh::hemocell
