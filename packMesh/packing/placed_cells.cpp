// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/placed_cells.h"

#include <algorithm>

#include "packMesh/core/tolerances.h"
#include "packMesh/placement/columns.h"
#include "packMesh/placement/placement.h"

namespace packmesh {
namespace {

/// Appends the initial cells [from, to) of a species, whose first cell has this id.
void place(const Physics& physics, const Execution& execution, AccessibleSpaces& spaces, int s,
           std::int64_t from, std::int64_t to, std::int64_t firstId, std::vector<Body>& bodies) {
  const Species& species = physics.species[s];
  const auto add = [&](std::int64_t cell, int shape, const Pose& pose) {
    bodies.push_back(makeBody(firstId + cell, s, shape, pose));
  };
  const auto deformed = std::int64_t(species.deformed.size());
  for (std::int64_t n = from; n < std::min(to, deformed); ++n) {
    const auto& [shape, start] = species.deformed[n];
    add(n, shape, start ? *start : placeRandomly(physics, execution, s, shape, firstId + n, 1).front());
  }
  from = std::clamp(from, deformed, std::max(to, deformed));
  const std::int64_t atRandom =
      std::clamp(deformed + std::int64_t(species.start.size()), from, std::max(from, to));
  for (std::int64_t n = from; n < atRandom; ++n) add(n, species.shape, species.start[n - deformed]);
  if (atRandom >= to) return;
  if (species.inColumns) {
    const Columns columns(physics.shapeOf(species), species.count, physics.container->bounds(),
                          physics.clearance + tolerance::relaxationMargin, physics.seed);
    for (std::int64_t n = atRandom; n < to; ++n) add(n, species.shape, columns.pose(n));
    return;
  }
  std::int64_t n = atRandom;
  const AccessibleSpace* const space = spaces.of(s);
  for (const Pose& pose :
       placeRandomly(physics, execution, s, species.shape, firstId + atRandom, to - atRandom, space))
    add(n++, species.shape, pose);
}

}  // namespace

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
    place(physics, execution, control.spaces(), s, from - speciesBegin, to - speciesBegin, speciesBegin,
          bodies);
  }
  if (control.outOfTime()) return {};
  return bodies;
}

}  // namespace packmesh
