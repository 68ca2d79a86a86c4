// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Soft cells of a problem: their membranes and limits, and the problem of the cells that were packed.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/problem.h"
#include "packMesh/soft/soft_engine.h"

namespace packmesh::hemocell {

/// What soft cells need to know of the species of a problem, in the order of its parts.
std::vector<SoftSpecies> softSpeciesOf(const Problem& problem, const PartsToPack& packed);

SoftLimits softLimitsOf(const Request& request);

/// The engine that packs soft cells of a problem. @param written see SoftEngine
std::shared_ptr<const Engine> softEngine(const Problem& problem, const PartsToPack& packed,
                                         std::function<Physics(const std::vector<Cell>&)> written);

/// Of a packing by that engine.
const SoftStatistics& statisticsOfSoft(const PackingResult& packed);

/// Why soft cells could not be packed: "the cells had grown to 0.91 of their size after 4000 iterations".
std::string failureOf(const SoftStatistics& reached, const SoftLimits& limits);

/// The problem of packing soft cells where they are. @param packed what was packed
/// @throws InputError, MeshError
Problem problemOfSoftCells(const Problem& problem, const PartsToPack& packed, const std::vector<Cell>& cells);

/// A warning of cells that were kept in regions and to directions before they grew, and are not any more.
std::optional<std::string> strayWarning(const Problem& problem, const PartsToPack& packed,
                                        const std::vector<Cell>& cells);

}  // namespace packmesh::hemocell
