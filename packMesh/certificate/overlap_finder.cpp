// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/overlap_finder.h"

#include <cmath>

#include "packMesh/parallel/per_thread.h"

namespace packmesh {
namespace {

/// Cells that a thread examines at a time.
constexpr std::int64_t searchedPerPart = 64;

}  // namespace

OverlapFinder::OverlapFinder(const CertificateInput& input, const PeriodicNeighbors& neighbors,
                             std::vector<Vec3> positions)
    : input_(input), cells_(input), listed_(std::move(positions)), neighbors_(neighbors) {}

/// With the shift between the cells where they are now: each may have been moved by whole periods.
NearPair OverlapFinder::asPlaced(const NearPair& pair) const {
  NearPair out = pair;
  if (!input_.container) return out;
  const Vec3 period = input_.container->period();
  const auto moved = [&](std::int64_t cell, int k) {
    return std::round((cells_.placement(cell).translation[k] - listed_[cell][k]) / period[k]);
  };
  for (int k = 0; k < 3; ++k) {
    if (!(period[k] > 0.0)) continue;
    const double periods = moved(pair.first, k) - moved(pair.second, k);
    if (periods != 0.0) out.shift[k] = (std::round(pair.shift[k] / period[k]) + periods) * period[k];
  }
  return out;
}

std::vector<OverlappingPair> OverlapFinder::operator()(const std::vector<std::int64_t>& moved) const {
  std::vector<char> isMoved(cells_.count(), 0);
  for (const std::int64_t i : moved) isMoved[i] = 1;
  PerThread<std::vector<OverlappingPair>> found(input_.threads);
  const auto examine = [&](std::int64_t i, std::vector<OverlappingPair>& faults) {
    const auto wanted = [&](std::int64_t other) {
      if (other < i && isMoved[other]) return false;  // examined from the other cell
      return cells_.isOwn(i) || cells_.isOwn(other);
    };
    neighbors_.forEachNear(i, input_.requiredGap, wanted, [&](const NearPair& near) {
      const NearPair pair = asPlaced(near);
      if (cells_.leastGap(pair) > input_.requiredGap) return;
      const MeshPairResult result = cells_.relation(pair, input_.requiredGap);
      if (const auto fault = cells_.faultOf(pair, result)) faults.push_back(*fault);
    });
  };
  input_.threads.forEachPart(
      static_cast<std::int64_t>(moved.size()),
      [&](std::int64_t begin, std::int64_t end, int thread) {
        for (std::int64_t k = begin; k < end; ++k) examine(moved[k], found[thread]);
      },
      searchedPerPart);
  std::vector<OverlappingPair> out;
  found.forEach([&](const auto& faults) { out.insert(out.end(), faults.begin(), faults.end()); });
  sortByCells(out);
  return out;
}

}  // namespace packmesh
