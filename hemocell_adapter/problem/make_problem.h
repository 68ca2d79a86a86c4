// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Making a problem of a request, and of the problem what is packed.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/completed_request.h"
#include "hemocell_adapter/problem/problem.h"
#include "packMesh/packing/packing_problem.h"

namespace packmesh::hemocell {

/// Tells the user how something was built.
void tell(const Notices& notices);

/// The problem of packing: shapes, lumen, walls, counts, and what is packed with the clearances demanded.
/// Does not communicate.
/// @param ranks that pack it
/// @throws UsageError, InputError, MeshError
Problem problemToPack(const CompletedRequest& completed, const Communicator& ranks = {});

/// The problem of examining cells: the species of .pos files or states, and their lumen. Their counts are 0.
/// @param folder of the .pos files
/// @throws UsageError, InputError, MeshError
Problem problemToCheck(const CompletedRequest& completed, const std::filesystem::path& folder,
                       const Communicator& ranks = {});

/// The problem of packing cells that are where they are to be.
/// @param clearances that they have
Problem problemOfExistingCells(const CompletedRequest& completed, std::vector<SpeciesPlan> plans,
                               const Clearances& clearances, const Communicator& ranks);

/// The problem with other cells, which are where they are to be, whatever it asks for.
/// @param plans of its species, with all of their cells and none of flowing blood @param clearances that they
/// have
/// @throws InputError, MeshError
Problem withOtherCells(Problem problem, std::vector<SpeciesPlan> plans, const Clearances& clearances);

/// The problem with the numbers of cells in the shells of its profile corrected by a packing of it
/// (correctedProfile()). All ranks call. Pre: it has a profile
Problem withCorrectedProfile(Problem problem, const PackingResult& packed);

/// Of cells whose volumes differ so much that no number of them has the hematocrit asked for, up to a cell.
std::optional<std::string> missedHematocritWarning(const Problem& problem);

/// What HemoCell cannot do with this number of cells of each species (see hemocell_limits.h).
std::vector<std::string> limitWarnings(const Scene& scene, const std::vector<std::int64_t>& counts);

/// The engine of Method::cat with the settings of the request.
std::shared_ptr<const Engine> engineFor(const Problem& problem, const PartsToPack& parts);

/// What the library packs. `interrupted` and `progress` are passed on. The certificate refers to the numbers
/// that formatPosLines() writes. References nothing of the problem.
PackingProblem packingProblemOf(const Problem& problem, const PartsToPack& parts,
                                std::function<bool()> interrupted = {},
                                std::function<void(const Progress&)> progress = {});

/// Names the cells of a result of packingProblemOf() by the species of the problem instead of its parts.
void nameBySpecies(const PartsToPack& parts, PackingResult& result);

}  // namespace packmesh::hemocell
