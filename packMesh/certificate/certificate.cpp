// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/certificate.h"

#include <algorithm>
#include <tuple>

namespace packmesh {

void sortByCells(std::vector<OverlappingPair>& pairs) {
  const auto key = [](const OverlappingPair& p) {
    return std::make_tuple(p.first, p.second, p.shift[0], p.shift[1], p.shift[2]);
  };
  std::sort(pairs.begin(), pairs.end(),
            [&](const OverlappingPair& a, const OverlappingPair& b) { return key(a) < key(b); });
}

Certificate ofAllRanks(const Certificate& own, const std::vector<std::int64_t>& numbers,
                       const Communicator& communicator) {
  struct Pair {
    std::int64_t first, second;
    double shift[3], gap;
    bool contained;
  };
  struct Misplaced {
    std::int64_t cell;
    double gap, required;
  };
  std::vector<Pair> pairs;
  for (const OverlappingPair& p : own.overlapping)
    pairs.push_back(
        {numbers[p.first], numbers[p.second], {p.shift[0], p.shift[1], p.shift[2]}, p.gap, p.contained});
  std::vector<Misplaced> misplaced;
  std::vector<std::string> reasons;
  for (const MisplacedCell& m : own.misplaced) {
    misplaced.push_back({numbers[m.cell], m.gap, m.required});
    reasons.push_back(m.reason);
  }
  std::vector<SelfIntersectingCell> selfIntersecting = own.selfIntersecting;
  for (SelfIntersectingCell& one : selfIntersecting) one.cell = numbers[one.cell];

  Certificate all;
  all.complete = !communicator.any(!own.complete);
  all.moreOverlaps = communicator.any(own.moreOverlaps);
  all.gapsMeasuredUpTo = own.gapsMeasuredUpTo;
  all.wallGapsMeasuredUpTo = own.wallGapsMeasuredUpTo;
  all.cells = communicator.sum(own.cells);
  all.pairsTested = communicator.sum(own.pairsTested);
  all.minimumGap = communicator.min(own.minimumGap);
  all.minimumWallGap = communicator.min(own.minimumWallGap);
  for (const double volume : communicator.gatherAll(std::vector<double>{own.cellVolume}))
    all.cellVolume += volume;
  for (const Pair& p : communicator.gatherAll(pairs))
    all.overlapping.push_back(
        {p.first, p.second, Vec3(p.shift[0], p.shift[1], p.shift[2]), p.contained, p.gap});
  sortByCells(all.overlapping);
  reasons = communicator.gatherRows(reasons);
  auto reason = reasons.begin();
  for (const Misplaced& m : communicator.gatherAll(misplaced))
    all.misplaced.push_back({m.cell, *reason++, m.gap, m.required});
  std::sort(all.misplaced.begin(), all.misplaced.end(),
            [](const MisplacedCell& a, const MisplacedCell& b) { return a.cell < b.cell; });
  all.selfIntersecting = communicator.gatherAll(selfIntersecting);
  std::sort(all.selfIntersecting.begin(), all.selfIntersecting.end(),
            [](const SelfIntersectingCell& a, const SelfIntersectingCell& b) { return a.cell < b.cell; });
  return all;
}

CertificateInput certificateInputOf(const Physics& physics, const std::vector<PlacedCell>& cells,
                                    const Threads& threads) {
  CertificateInput input;
  for (const auto& shape : physics.shapes) input.shapes.push_back(shape.get());
  for (const Species& species : physics.species) {
    input.walls.push_back(physics.wallOf(species));
    input.extraWallGap.push_back(species.freedom.extraWallClearance);
  }
  input.container = physics.container.get();
  input.cells = &cells;
  input.requiredGap = physics.clearance;
  input.requiredWallGap = physics.wallClearance;
  input.largestGap = measuredUpTo(input.requiredGap);
  for (std::size_t s = 0; s < physics.species.size(); ++s)
    input.largestWallGap = std::max(input.largestWallGap, measuredUpTo(input.wallGapOf(int(s))));
  input.threads = threads;
  return input;
}

}  // namespace packmesh
