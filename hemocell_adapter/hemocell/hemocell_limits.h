// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What HemoCell cannot hold unless its case is changed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/case_config.h"
#include "hemocell_adapter/hemocell/case_source.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh::hemocell {

/// HemoCell numbers the periodic images of cells, and ends when those numbers could overflow: with its
/// default limits above 212,622 cells.
/// @param calls those of setSystemPeriodicityLimit in the case
/// @return what to add to the case's C++ code; nothing when so many cells are possible
std::optional<std::string> cellNumberWarning(std::int64_t cells, const std::vector<PeriodicityCall>& calls);

/// HemoCell knows the vertices of a cell only as far as `<particleEnvelope>` beyond the block of its centre.
/// @return what to write there; nothing when it is wide enough for this cell at rest, or not stated
std::optional<std::string> envelopeWarning(const std::string& cell, const TriangleMesh& mesh,
                                           const Domain& domain);

/// The largest distance between two vertices.
double longestExtent(const TriangleMesh& mesh);

}  // namespace packmesh::hemocell
