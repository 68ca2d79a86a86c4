// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Division of the user's species into parts that packing treats differently: fixed cells, and those of
/// each region.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// The regions of a request and, as the last one, the rest; empty if it has none.
/// @throws InputError if one lies outside the lumen
/// @param hematocrit of the rest @param repairs of meshes are added
std::vector<LumenRegion> makeRegions(const Request& asked, std::optional<double> hematocrit,
                                     const Lumen& lumen, const Threads& team,
                                     std::vector<std::string>& repairs);

/// Index of the region that contains a point.
int regionAt(const std::vector<LumenRegion>& regions, const Vec3& point);

/// Movable cells of a species, anywhere in the lumen. @param packed with its walls
Species freeCells(const Scene& scene, const PartsToPack& packed, int species, std::int64_t count);

/// What is packed with these clearances: all species in order, each in parts: fixed cells first, red cells by
/// region. If there are more initial cells than requested, a random subset is used.
/// Pre: the species have their numbers
/// @throws InputError if there are more fixed cells than requested
PartsToPack partsAt(const Scene& scene, const Layout& layout, const Clearances& clearances);

/// Warnings about the red cells of the regions.
/// @throws InputError if a region requests red cells and is too small for one
std::vector<std::string> examineRegions(const Scene& scene, const Layout& layout,
                                        const std::vector<Part>& parts);

}  // namespace packmesh::hemocell
