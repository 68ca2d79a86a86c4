// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Initial poses of cells in the shells of a profile.
#pragma once

#include <cstdint>
#include <vector>

#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// Poses of cells of a species with their centres in the shells of the profile, spread evenly over each: the
/// first points of one quasirandom sequence over the lumen that lie in it, with random orientations. Fewer
/// than asked for where hardly a point is in a shell. Every rank computes all of them.
/// @param counts for each shell
std::vector<std::vector<Pose>> startInShells(const Problem& problem, int species,
                                             const std::vector<std::int64_t>& counts);

}  // namespace packmesh::hemocell
