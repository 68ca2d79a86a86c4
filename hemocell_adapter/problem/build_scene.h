// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Building the scene of a job, and the problem that is packed.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/scene.h"
#include "packMesh/packing/packing_problem.h"

namespace packmesh::hemocell {

/// Builds shapes, lumen, walls and, for packing, counts. Does not communicate.
/// @param ranks that pack the scene
/// @throws InputError, MeshError
Scene buildScene(Job job, const Communicator& ranks = {});

/// Updates parts and walls of a scene that is to be packed with these clearances, which initially are those
/// demanded.
void setClearances(Scene& scene, const Clearances& clearances);

/// What HemoCell cannot do with this number of cells of each species (see hemocell_limits.h).
std::vector<std::string> limitWarnings(const Scene& scene, const std::vector<std::int64_t>& counts);

/// The problem to be packed. `interrupted` and `progress` are passed on. The certificate refers to the
/// numbers that formatPos writes.
PackingProblem problemOf(const Scene& scene, std::function<bool()> interrupted,
                         std::function<void(const Progress&)> progress);

}  // namespace packmesh::hemocell
