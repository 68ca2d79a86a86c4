// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/cell_surroundings.h"

#include <algorithm>
#include <tuple>

namespace packmesh {
namespace {

std::vector<Sphere> spheresAround(const Physics& physics, const std::vector<Body>& cells,
                                  const std::vector<double>& reach) {
  std::vector<Sphere> spheres;
  spheres.reserve(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i)
    spheres.push_back(
        {cells[i].position, cells[i].scale * physics.shapeOf(cells[i].species).radius() + reach[i]});
  return spheres;
}

}  // namespace

CellSurroundings::CellSurroundings(const Physics& physics, const std::vector<Body>& cells,
                                   std::vector<double> reach)
    : cells_(cells),
      reach_(std::move(reach)),
      clearance_(physics.clearance),
      neighbors_(spheresAround(physics, cells, reach_), physics.container->period()) {}

std::vector<NearPair> CellSurroundings::pairsOf(const std::vector<std::int64_t>& wanted,
                                                double further) const {
  std::vector<NearPair> pairs;
  for (const std::int64_t cell : wanted)
    neighbors_.forEachNear(cell, clearance_ + further, false, [&](const NearPair& pair) {
      const std::int64_t other = pair.first == cell ? pair.second : pair.first;
      if (other < cell && std::binary_search(wanted.begin(), wanted.end(), other)) return;  // already visited
      pairs.push_back(pair);
    });
  std::sort(pairs.begin(), pairs.end(), [](const NearPair& a, const NearPair& b) {
    return std::tie(a.first, a.second, a.shift[0], a.shift[1], a.shift[2]) <
           std::tie(b.first, b.second, b.shift[0], b.shift[1], b.shift[2]);
  });
  return pairs;
}

}  // namespace packmesh
