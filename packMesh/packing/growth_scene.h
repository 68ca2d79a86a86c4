// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A problem as growth sees it.
#pragma once

#include "packMesh/packing/packing_problem.h"

namespace packmesh {

/// References the problem, which must outlive it.
inline GrowthScene growthSceneOf(const PackingProblem& problem) {
  GrowthScene scene;
  for (const Species& species : problem.species) {
    scene.shapes.push_back(species.shape.get());
    scene.walls.push_back(problem.wallOf(species));
  }
  scene.container = problem.container.get();
  scene.clearance = problem.clearance;
  scene.wallClearance = problem.wallClearance;
  scene.rotate = problem.rotate;
  scene.seed = problem.seed;
  scene.written = problem.written;
  return scene;
}

}  // namespace packmesh
