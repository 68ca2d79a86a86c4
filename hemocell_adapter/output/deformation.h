// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How much the cells of a packing are deformed, by the membranes that HemoCell gives them.
#pragma once

#include <optional>
#include <vector>

#include "hemocell_adapter/output/packing.h"
#include "packMesh/packing/packing_file.h"

namespace packmesh::hemocell {

/// Of all ranks, of the cells that have meshes of their own; nothing if there are none, or none whose
/// membrane HemoCell's laws can be applied to. All ranks call.
std::optional<Deformations> deformationsOf(const Packing& packing);

/// The same of each of these cells, which are of one rank: columns `force` [pN], and `volume_change`,
/// `area_change`, `triangle_change`, `edge_change` [fraction]. 0 of a cell with the mesh of the template. No
/// columns if the problem has no meshes but templates.
std::vector<CellColumn> deformationColumns(const Problem& problem, const std::vector<PlacedCell>& cells);

/// Of the cells of a state.
std::vector<CellColumn> deformationColumns(const Problem& problem, const PackedParts& packed,
                                           const std::vector<BodyState>& cells);

}  // namespace packmesh::hemocell
