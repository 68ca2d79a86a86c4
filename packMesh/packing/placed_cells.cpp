// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/placed_cells.h"

#include <algorithm>

#include "packMesh/core/tolerances.h"
#include "packMesh/placement/columns.h"
#include "packMesh/placement/placement.h"

namespace packmesh {
namespace {

/// Initial cells [from, to) of a species, whose first cell has this id.
std::vector<Pose> startOf(const Physics& physics, const Execution& execution, int s, std::int64_t from,
                          std::int64_t to, std::int64_t firstId) {
  const Species& species = physics.species[s];
  const std::int64_t atRandom = std::clamp(static_cast<std::int64_t>(species.start.size()), from, to);
  std::vector<Pose> poses(species.start.begin() + std::min(from, atRandom), species.start.begin() + atRandom);
  if (species.inColumns) {
    const Columns columns(*species.shape, species.count, physics.container->bounds(),
                          physics.clearance + tolerance::relaxationMargin, physics.seed);
    for (std::int64_t cell = from; cell < to; ++cell) poses.push_back(columns.pose(cell));
    return poses;
  }
  std::vector<Pose> placed = placeRandomly(physics, execution, s, firstId + atRandom, to - atRandom);
  placed.insert(placed.begin(), poses.begin(), poses.end());
  return placed;
}

}  // namespace

bool startsAtGivenPose(const Species& species, std::int64_t cell) {
  return species.inColumns || cell < static_cast<std::int64_t>(species.start.size());
}

std::optional<std::vector<Body>> placedCells(const Physics& physics, Execution execution,
                                             const IdShares& shares, RunControl& control) {
  execution.interrupted = [&] { return control.outOfTimeHere(); };
  const auto [first, end] = shares.own();
  std::vector<Body> bodies;
  bodies.reserve(end - first);
  std::int64_t begin = 0;  // first id of the species
  for (std::size_t i = 0; i < physics.species.size(); ++i) {
    const int s = static_cast<int>(i);
    const std::int64_t speciesBegin = begin;
    begin += physics.species[i].count;
    const std::int64_t from = std::max(first, speciesBegin), to = std::min(end, begin);
    if (from >= to) continue;
    std::int64_t id = from;
    for (const Pose& pose :
         startOf(physics, execution, s, from - speciesBegin, to - speciesBegin, speciesBegin))
      bodies.push_back(makeBody(id++, s, pose));
  }
  if (control.outOfTime()) return {};
  return bodies;
}

}  // namespace packmesh
