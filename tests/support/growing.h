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

/// Random cells at a scale, free of overlap.
/// @param counts cells of each species
inline std::vector<Body> seeded(const Physics& physics, const std::vector<std::int64_t>& counts,
                                double scale) {
  std::vector<Body> cells;
  for (std::size_t s = 0; s < counts.size(); ++s) {
    const auto first = static_cast<std::int64_t>(cells.size());
    for (Pose pose : placeRandomly(physics, {}, static_cast<int>(s), first, counts[s])) {
      pose.scale = scale;
      cells.push_back(makeBody(static_cast<std::int64_t>(cells.size()), static_cast<int>(s), pose));
    }
  }
  if (!seed(physics, {}, scale, {}, cells)) throw std::runtime_error("no valid first state");
  return cells;
}

/// The planes of all cells, any point of which may move as far as `reach` [µm].
inline PlaneConstraints planesOf(PlaneFunction& planeFunction, const Physics& physics,
                                 const std::vector<Body>& cells, double reach, double detail = 1.0) {
  const CellSurroundings surroundings(physics, cells, std::vector<double>(cells.size(), reach));
  PlaneRequest request{surroundings, {}, detail, reach};
  request.wanted.resize(cells.size());
  std::iota(request.wanted.begin(), request.wanted.end(), std::int64_t{0});
  planeFunction.begin({request});
  return planeFunction(request);
}

/// Takes steps, one for each cell. Pre: cell i has the id i
inline void takeSteps(const Physics& physics, const std::vector<GrowthStep>& steps, std::vector<Body>& cells,
                      StepHalvingSums& sums) {
  const Execution alone;
  GrowingCells growing(physics, alone, cells, 1e9, 0);
  std::vector<GrowthStep> inOrder;
  for (const Body& cell : growing.all()) inOrder.push_back(steps[cell.id]);
  StepHalving(physics, alone).take(inOrder, growing, sums);
  cells = growing.own();
}

/// What is wrong with cells that are all on this rank.
inline Certificate examine(const Physics& physics, const std::vector<Body>& cells) {
  std::vector<std::int64_t> all(cells.size());
  std::iota(all.begin(), all.end(), std::int64_t{0});
  return StepHalving(physics, {}).examine(cells, all);
}

}  // namespace packmesh::test
