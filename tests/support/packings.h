// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Packing problems for tests.
#pragma once

#include <cmath>
#include <memory>

#include "packMesh/container/primitives.h"
#include "packMesh/packing/pack.h"
#include "packMesh/relaxation/body.h"
#include "tests/support/shapes.h"

namespace packmesh::test {

inline std::shared_ptr<const Container> periodicCube(double edge) {
  return makeBox(Box{Vec3::Zero(), Vec3::Constant(edge)}, {true, true, true});
}

/// HemoCell's red cell at a volume fraction.
inline PackingProblem redCellProblem(std::shared_ptr<const Container> container, double fraction,
                                     std::uint64_t seed = 1) {
  PackingProblem problem;
  const auto count = std::int64_t(fraction * container->volume() / redCellShape()->volume());
  problem.physics.add("RBC", redCellShape(), count);
  problem.physics.container = std::move(container);
  problem.physics.seed = seed;
  return problem;
}

inline bool sameBits(const PackingResult& a, const PackingResult& b) {
  if (a.cells.size() != b.cells.size()) return false;
  for (std::size_t i = 0; i < a.cells.size(); ++i)
    if (a.cells[i].species != b.cells[i].species || a.cells[i].shape != b.cells[i].shape ||
        a.cells[i].placement.linear != b.cells[i].placement.linear ||
        a.cells[i].placement.translation != b.cells[i].placement.translation)
      return false;
  return true;
}

/// Red cells at this fraction of the container's volume, and small spheres among them.
inline PackingProblem mixtureIn(std::shared_ptr<const Container> container, double fraction,
                                std::uint64_t seed) {
  PackingProblem problem;
  const std::shared_ptr<const Shape> red = redCellShape(), ball = sphereShape(1.0);
  problem.physics.add("RBC", red, std::int64_t(fraction * container->volume() / red->volume()));
  problem.physics.add("PLT", ball, 1 + problem.physics.species[0].count / 14);
  problem.physics.container = std::move(container);
  problem.physics.seed = seed;
  return problem;
}

/// Red cells of a packing in a periodic cube that has shrunk by a factor since, so that some overlap: as
/// after a compaction, to be calibrated. With several ranks the first one has all cells.
inline PackingProblem toBeCalibrated(double edge, double fraction, double factor,
                                     const Communicator& communicator = {}) {
  const PackingResult packed = pack(redCellProblem(periodicCube(edge), fraction));
  PackingProblem problem = redCellProblem(periodicCube(factor * edge), 0.0);
  problem.physics.species[0].count = packed.cellCount;
  problem.execution.communicator = communicator;
  PackingState& state = problem.resume.emplace();
  state.position = {Stage::certificate, false, 0, {3, 0}};
  state.cellCount = packed.cellCount;
  if (communicator.rank() == 0)
    for (std::size_t i = 0; i < packed.poses.size(); ++i) {
      Pose pose = packed.poses[i];
      pose.position *= factor;
      state.cells.push_back(makeBody(std::int64_t(i), 0, 0, pose));
    }
  return problem;
}

}  // namespace packmesh::test
