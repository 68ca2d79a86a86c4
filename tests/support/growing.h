// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Growing cells on one rank, for tests.
#pragma once

#include <numeric>
#include <stdexcept>
#include <vector>

#include "packMesh/cat/growing_cells.h"
#include "packMesh/cat/step_halving.h"
#include "packMesh/placement/placement.h"

namespace packmesh::test {

/// Cells of the first species.
inline std::vector<Body> bodiesAt(const std::vector<Pose>& poses, double scale = 1.0) {
  std::vector<Body> cells;
  for (Pose pose : poses) {
    pose.scale = scale;
    cells.push_back(makeBody(std::int64_t(cells.size()), 0, 0, pose));
  }
  return cells;
}

/// Random cells at a scale, free of overlap.
/// @param counts cells of each species
inline std::vector<Body> seeded(const Physics& physics, const std::vector<std::int64_t>& counts,
                                double scale) {
  std::vector<Body> cells;
  for (std::size_t s = 0; s < counts.size(); ++s) {
    const auto first = std::int64_t(cells.size());
    for (Pose pose : placeRandomly(physics, {}, int(s), int(s), first, counts[s])) {
      pose.scale = scale;
      cells.push_back(makeBody(std::int64_t(cells.size()), int(s), int(s), pose));
    }
  }
  if (!seed(physics, {}, scale, {}, cells)) throw std::runtime_error("no valid first state");
  return cells;
}

/// The planes of a cell in its pose.
inline std::vector<PlaneConstraint> constraintsOf(const CellPlanes& planes, const Pose& pose) {
  std::vector<PlaneConstraint> constraints;
  const Mat3 toBody = pose.orientation.toRotationMatrix().transpose();
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const auto at = [&](int first) {
      return Vec3(planes.column(first)[i], planes.column(first + 1)[i], planes.column(first + 2)[i]);
    };
    const Vec3 normal = at(CellPlanes::normal);
    constraints.push_back({toBody * at(CellPlanes::arm),
                           pose.position + planes.column(CellPlanes::distance)[i] * normal, normal});
  }
  return constraints;
}

/// The planes of the requested cells.
inline PlaneConstraints constraintsFor(PlaneFunction& planeFunction, const PlaneRequest& request) {
  std::vector<CellPlanes> planes(request.wanted.size());
  planeFunction(request, planes);
  PlaneConstraints constraints;
  for (std::size_t k = 0; k < planes.size(); ++k)
    constraints.push_back(constraintsOf(planes[k], request.surroundings.cells()[request.wanted[k]].pose()));
  return constraints;
}

/// The planes of all cells, any point of which may move as far as `reach` [µm].
inline PlaneConstraints planesOf(PlaneFunction& planeFunction, const Physics& physics,
                                 const std::vector<Body>& cells, double reach, double detail = 1.0) {
  const CellSurroundings surroundings(physics, cells, std::vector<double>(cells.size(), reach),
                                      std::vector<double>(cells.size(), 0.0));
  PlaneRequest request{surroundings, {}, detail, reach};
  request.wanted.resize(cells.size());
  std::iota(request.wanted.begin(), request.wanted.end(), std::int64_t{0});
  planeFunction.begin({request});
  return constraintsFor(planeFunction, request);
}

/// Takes steps, one for each cell. Pre: cell i has the id i
inline void takeSteps(const Physics& physics, const std::vector<GrowthStep>& steps, std::vector<Body>& cells,
                      StepHalvingSums& sums) {
  const Execution alone;
  GrowingCells growing(physics, alone, cells, 1e9, 0);
  std::vector<GrowthStep> inOrder;
  for (const Body& cell : growing.all()) inOrder.push_back(steps[cell.id]);
  std::vector<double> extent;
  for (std::size_t i = 0; i < inOrder.size(); ++i) {
    const Body& cell = growing.all()[i];
    extent.push_back(std::max(cell.scale, inOrder[i].scale) * physics.shapeOf(cell).reach() +
                     inOrder[i].translation.norm());
  }
  const CellSurroundings surroundings(physics, growing.all(), std::vector<double>(extent.size(), 0.0),
                                      extent);
  StepHalving(physics, alone).take(inOrder, surroundings, growing, sums);
  cells = growing.own();
}

/// What is wrong with cells that are all on this rank.
inline Certificate examine(const Physics& physics, const std::vector<Body>& cells) {
  std::vector<std::int64_t> all(cells.size());
  std::iota(all.begin(), all.end(), std::int64_t{0});
  return StepHalving(physics, {}).examine(cells, all);
}

}  // namespace packmesh::test
