// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Making a problem of a request, and of the problem what is packed.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/completed_request.h"
#include "hemocell_adapter/problem/problem.h"
#include "packMesh/packing/packing_problem.h"

namespace packmesh::hemocell {

/// Tells the user how a problem was built.
void logNotices(const Problem& problem);

/// The problem of packing: shapes, lumen, walls, counts, and what is packed with the clearances demanded.
/// Does not communicate.
/// @param ranks that pack it
/// @throws UsageError, InputError, MeshError
Problem problemToPack(const CompletedRequest& completed, const Communicator& ranks = {});

/// The problem of examining cells: the species of .pos files or states, and their lumen. Their counts are 0.
/// @throws UsageError, InputError, MeshError
Problem problemToCheck(const CompletedRequest& completed, const Communicator& ranks = {});

/// The problem of packing a larger box with cells that are there: those of `result`, whose species are the
/// problem's, with all images of a cell in succession. All ranks call; each gets all cells.
/// @param clearances that the packing has
/// @throws InputError as requireTileable()
Problem tiledProblem(const Problem& problem, const Clearances& clearances, const PackingResult& result);

/// The problem with the numbers of cells in the shells of its profile corrected by a packing of it
/// (correctedProfile()). All ranks call. Pre: it has a profile
Problem withCorrectedProfile(const Problem& problem, const PackingResult& packed);

/// @throws InputError if the box is not periodic along an axis along which it is repeated, or if there are
///   too many cells
void requireTileable(const Problem& problem);

/// What HemoCell cannot do with this number of cells of each species (see hemocell_limits.h).
std::vector<std::string> limitWarnings(const Problem& problem, const std::vector<std::int64_t>& counts);

/// The engine of Method::cat with the settings of the request.
std::shared_ptr<const Engine> engineFor(const Problem& problem, const PackedParts& parts);

/// What the library packs. `interrupted` and `progress` are passed on. The certificate refers to the numbers
/// that formatPosLines() writes. References the problem.
PackingProblem packingProblemOf(const Problem& problem, const PackedParts& parts,
                                std::function<bool()> interrupted = {},
                                std::function<void(const Progress&)> progress = {});

/// Names the cells of a result of packingProblemOf() by the species of the problem instead of its parts.
void nameBySpecies(const PackedParts& parts, PackingResult& result);

}  // namespace packmesh::hemocell
