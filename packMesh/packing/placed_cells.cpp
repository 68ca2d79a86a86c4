// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/placed_cells.h"

#include <algorithm>

#include "packMesh/core/tolerances.h"
#include "packMesh/placement/columns.h"
#include "packMesh/placement/placement.h"

namespace packmesh {
namespace {

/// Initial cells [from, to) of a species; the first of them has this id.
std::vector<Pose> startOf(const PackingProblem& problem, std::uint64_t seed, const Species& species,
                          std::int64_t from, std::int64_t to, std::int64_t firstId,
                          const RunControl& control) {
  const std::int64_t atRandom = std::clamp(static_cast<std::int64_t>(species.start.size()), from, to);
  std::vector<Pose> poses(species.start.begin() + std::min(from, atRandom), species.start.begin() + atRandom);
  if (species.inColumns) {
    const Columns columns(*species.shape, species.count, problem.container->bounds(),
                          problem.clearance + tolerance::relaxationMargin, seed);
    for (std::int64_t cell = from; cell < to; ++cell) poses.push_back(columns.pose(cell));
    return poses;
  }
  const PlacementInput random{species.shape.get(), problem.wallOf(species), firstId + atRandom,
                              to - atRandom,       &species.freedom,        problem.threads};
  const auto stop = [&] { return control.outOfTimeHere(); };
  std::vector<Pose> placed = placeRandomly(random, problem.container->bounds(), seed, problem.rotate, stop);
  placed.insert(placed.begin(), poses.begin(), poses.end());
  return placed;
}

}  // namespace

bool startsAtGivenPose(const Species& species, std::int64_t cell) {
  return species.inColumns || cell < static_cast<std::int64_t>(species.start.size());
}

std::optional<std::vector<Body>> placedCells(const PackingProblem& problem, std::uint64_t seed,
                                             const IdShares& shares, RunControl& control) {
  const auto [first, end] = shares.own();
  std::vector<Body> bodies;
  bodies.reserve(end - first);
  std::int64_t begin = 0;  // first id of the species
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    const Species& species = problem.species[s];
    const std::int64_t speciesBegin = begin;
    begin += species.count;
    const std::int64_t from = std::max(first, speciesBegin), to = std::min(end, begin);
    if (from >= to) continue;
    std::int64_t id = from;
    for (const Pose& pose :
         startOf(problem, seed, species, from - speciesBegin, to - speciesBegin, speciesBegin, control))
      bodies.push_back(makeBody(id++, static_cast<int>(s), pose));
  }
  if (control.outOfTime()) return {};
  return bodies;
}

}  // namespace packmesh
