// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Growing cells on one rank, for tests.
#pragma once

#include <numeric>
#include <stdexcept>
#include <vector>

#include "packMesh/growth/plane_function.h"
#include "packMesh/growth/seeding.h"
#include "packMesh/growth/step_halving.h"
#include "packMesh/placement/placement.h"

namespace packmesh::test {

/// Random cells of a scene at a scale, free of overlap.
/// @param counts cells of each species
inline std::vector<Body> seeded(const GrowthScene& scene, const std::vector<std::int64_t>& counts,
                                double scale) {
  std::vector<Body> cells;
  for (std::size_t s = 0; s < counts.size(); ++s) {
    const auto first = static_cast<std::int64_t>(cells.size());
    const PlacementInput input{scene.shapes[s], scene.walls[s], first, counts[s],
                               scene.freedomOf(static_cast<int>(s))};
    for (Pose pose : placeRandomly(input, scene.container->bounds(), scene.seed, scene.rotate)) {
      pose.scale = scale;
      cells.push_back(makeBody(static_cast<std::int64_t>(cells.size()), static_cast<int>(s), pose));
    }
  }
  if (!seed(scene, scale, {}, cells)) throw std::runtime_error("no valid first state");
  return cells;
}

/// The planes of all cells, any point of which may move as far as `reach` [µm].
inline PlaneConstraints planesOf(PlaneFunction& planeFunction, const GrowthScene& scene,
                                 const std::vector<Body>& cells, double reach, double detail = 1.0) {
  const CellSurroundings surroundings(scene, cells, std::vector<double>(cells.size(), reach));
  PlaneRequest request{surroundings, {}, detail, reach};
  request.wanted.resize(cells.size());
  std::iota(request.wanted.begin(), request.wanted.end(), std::int64_t{0});
  return planeFunction(request);
}

/// Takes steps, one for each cell. Pre: cell i has the id i
inline void takeSteps(const GrowthScene& scene, const std::vector<GrowthStep>& steps,
                      std::vector<Body>& cells, StepHalvingSums& sums) {
  GrowingCells growing(scene, cells, 1e9, 0);
  std::vector<GrowthStep> inOrder;
  for (const Body& cell : growing.all()) inOrder.push_back(steps[cell.id]);
  StepHalving(scene).take(inOrder, growing, sums);
  cells = growing.own();
}

/// What is wrong with cells that are all on this rank.
inline Certificate examine(const GrowthScene& scene, const std::vector<Body>& cells) {
  std::vector<std::int64_t> all(cells.size());
  std::iota(all.begin(), all.end(), std::int64_t{0});
  return StepHalving(scene).examine(cells, all);
}

}  // namespace packmesh::test
