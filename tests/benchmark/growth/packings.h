// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Packings by growth, and the table of what they take.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/cell_model.h"
#include "packMesh/container/primitives.h"
#include "packMesh/packing/packing_problem.h"
#include "tests/benchmark/growth/cases.h"
#include "tests/support/cat.h"

namespace packmesh::benchmark {

/// One packing and what it is expected to take.
struct GrownPacking {
  std::string name;
  std::function<PackingProblem()> problem;
  double allowedSeconds = 0.0;  ///< CPU time allowed [s]; 0: none stated
};

/// Packs, and certifies every accepted state by itself.
/// @return the number of states; -1 when one was not valid
std::int64_t checkStates(PackingProblem problem);

/// A case that makes these packings and prints a line for each.
Case packings(std::string name, std::string about, std::vector<GrownPacking> of);

inline std::shared_ptr<const Shape> redCell() {
  return hemocell::makeShape(*hemocell::defaultModel("RBC"), 0.5);
}

/// `count` cells, to be grown.
inline PackingProblem grown(std::shared_ptr<const Shape> shape, std::int64_t count,
                            std::shared_ptr<const Container> container,
                            PlaneSource planeSource = PlaneSource::chords) {
  PackingProblem problem;
  problem.physics.add("cell", std::move(shape), count);
  problem.physics.container = std::move(container);
  test::useCat(problem).planeSource = planeSource;
  return problem;
}

/// A sphere of which `count` cells are the given fraction.
std::unique_ptr<Container> sphereFor(const Shape& shape, std::int64_t count, double fraction);

/// Red cells that are the given fraction of a periodic cube.
PackingProblem grownInBox(double edge, double fraction, PlaneSource planeSource = PlaneSource::chords);

}  // namespace packmesh::benchmark
