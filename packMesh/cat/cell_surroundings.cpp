// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/cell_surroundings.h"

#include <algorithm>
#include <tuple>

namespace packmesh {
namespace {

/// @param extent becomes how much larger the spheres are than cells and their reach
std::vector<Sphere> spheresAround(const Physics& physics, const std::vector<Body>& cells,
                                  const std::vector<double>& reach, std::vector<double>& extent) {
  std::vector<Sphere> spheres;
  spheres.reserve(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const double least = cells[i].scale * physics.shapeOf(cells[i].species).radius() + reach[i];
    extent[i] = std::max(0.0, extent[i] - least);
    spheres.push_back({cells[i].position, least + extent[i]});
  }
  return spheres;
}

}  // namespace

CellSurroundings::CellSurroundings(const Physics& physics, const std::vector<Body>& cells,
                                   std::vector<double> reach, std::vector<double> extent)
    : cells_(cells),
      reach_(std::move(reach)),
      beyond_(std::move(extent)),
      clearance_(physics.clearance),
      neighbors_(spheresAround(physics, cells, reach_, beyond_), physics.container->period()) {}

template <class Wanted, class Visit>
void CellSurroundings::forEachNear(std::int64_t cell, const Wanted& wanted, const Visit& visit) const {
  neighbors_.forEachNear(cell, clearance_, wanted, [&](const NearPair& pair) {
    if (pair.apart + (beyond_[pair.first] + beyond_[pair.second]) < clearance_) visit(pair);
  });
}

bool CellSurroundings::isNear(std::int64_t cell, const std::vector<char>& marked) const {
  bool near = false;
  const auto isMarked = [&](std::int64_t other) { return !near && marked[other]; };
  forEachNear(cell, isMarked, [&](const NearPair&) { near = true; });
  return near;
}

std::vector<NearPair> CellSurroundings::pairsOf(const std::vector<std::int64_t>& wanted) const {
  std::vector<NearPair> pairs;
  for (const std::int64_t cell : wanted) {
    const auto notYet = [&](std::int64_t other) {
      return other >= cell || !std::binary_search(wanted.begin(), wanted.end(), other);
    };
    forEachNear(cell, notYet, [&](const NearPair& pair) { pairs.push_back(pair); });
  }
  std::sort(pairs.begin(), pairs.end(), [](const NearPair& a, const NearPair& b) {
    return std::tie(a.first, a.second, a.shift[0], a.shift[1], a.shift[2]) <
           std::tie(b.first, b.second, b.shift[0], b.shift[1], b.shift[2]);
  });
  return pairs;
}

}  // namespace packmesh
