// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A species of the user's, cut into parts that packing treats differently: fixed cells, and those of
/// each region.
#pragma once

#include <string>
#include <vector>

#include "hemocell_adapter/problem/scene.h"

namespace packmesh::hemocell {

/// The regions of the job and, as the last one, the rest; empty when the job has none.
/// @throws InputError when one lies outside the lumen
std::vector<LumenRegion> makeRegions(const Job& job, const Lumen& lumen);

/// Index of the region that a point is in.
int regionAt(const std::vector<LumenRegion>& regions, const Vec3& point);

/// So many cells of a species that may move, anywhere in the lumen. Pre: the species has its wall.
Species freeCells(const Scene& scene, const CellSpecies& species, std::int64_t count);

/// All species in order, each in parts: fixed cells first, red cells by region. Of more cells to start with
/// than are asked for, some are drawn without bias.
/// @throws InputError when more cells are fixed than asked for
std::vector<ScenePart> makeParts(const Scene& scene);

/// What the user should know about the red cells of the regions. Pre: the scene has its parts.
/// @throws InputError when a region asks for red cells and is too small for one
std::vector<std::string> examineRegions(const Scene& scene);

}  // namespace packmesh::hemocell
