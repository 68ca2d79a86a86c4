// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file From the profile that is asked for to shells in which cells are packed, and what was reached.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// How the cells are distributed so that their volume has the profile that is asked for.
///
/// A cell extends over several layers, so the volume of cells whose centre is in a shell is spread over its
/// surroundings. Random poses that fit the lumen show how; the numbers of cells in the shells follow by
/// deconvolution (Richardson 1972, Lucy 1974: the expectation maximisation of a mixture). The numbers of
/// cells are those of the species. Every rank computes the same. Pre: the species have their numbers, and the
/// request asks for a profile
/// @throws InputError if there is no wall, or if nothing that is packed has a profile
std::shared_ptr<const DepthProfile> planProfile(const Scene& scene, std::vector<std::string>& notices);

/// @throws InputError if a shell would hold more cells than can be packed
void refuseTooDense(const Scene& scene, const DepthProfile& profile);

/// The profile of a problem with the numbers of cells corrected by a packing of it, in which cells are not
/// where random ones would be: in the core they press outwards. The same on all ranks, which all call.
/// @param packed from the problem at the clearances demanded: all its cells, of which this rank has its share
std::shared_ptr<const DepthProfile> correctedProfile(const Problem& problem, const PackingResult& packed);

/// Volume fractions of each species with a profile in each shell, [species][shell]; empty for others. The
/// same on all ranks, which all call. @param cells of this rank, named by the species of the problem
std::vector<std::vector<double>> reachedProfile(const Problem& problem, const std::vector<PlacedCell>& cells);

}  // namespace packmesh::hemocell
