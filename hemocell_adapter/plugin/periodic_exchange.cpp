// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/plugin/periodic_exchange.h"

#include <fmt/format.h>

#include "hemocell_adapter/base/log.h"

namespace packmesh::hemocell {
namespace {

/// The nodes of a block, both ends included.
struct Extent {
  std::int64_t rank;
  std::array<std::int64_t, 3> first, last;
};

/// Whether `from`, moved by `images` periods, meets the envelope of `to`.
bool reaches(const Extent& from, const std::array<int, 3>& images, const Extent& to,
             const plugin::System& system) {
  for (int a = 0; a < 3; ++a) {
    const std::int64_t shift = images[a] * (system.last[a] - system.first[a] + 1);
    if (from.first[a] + shift > to.last[a] + system.particleEnvelope ||
        from.last[a] + shift < to.first[a] - system.particleEnvelope)
      return false;
  }
  return true;
}

}  // namespace

bool losesCells(const plugin::System& system, const Communicator& ranks) {
  std::vector<Extent> mine;
  for (const plugin::Block& block : system.blocks) mine.push_back({ranks.rank(), block.first, block.last});
  std::vector<int> exchanges(ranks.size(), 0);    // across periodic faces, with each rank
  std::vector<bool> needed(ranks.size(), false);  // some of them
  for (const Extent& from : ranks.gatherAll(mine)) {
    if (from.rank == ranks.rank()) continue;
    for (const Extent& to : mine)
      for (int image = 0; image < 27; ++image) {
        const std::array<int, 3> images = {image % 3 - 1, image / 3 % 3 - 1, image / 9 - 1};
        bool across = false, possible = true, divided = false;
        for (int a = 0; a < 3; ++a) {
          if (images[a] == 0) continue;
          across = true;
          possible = possible && system.periodic[a];
          divided = divided || to.first[a] > system.first[a] || to.last[a] < system.last[a];
        }
        if (!across || !possible || !reaches(from, images, to, system)) continue;
        ++exchanges[from.rank];
        needed[from.rank] = needed[from.rank] || divided;
      }
  }
  bool loses = false;
  for (int r = 0; r < ranks.size(); ++r) loses = loses || (exchanges[r] > 1 && needed[r]);
  return ranks.any(loses);
}

void warnOfLostCells(const plugin::System& system, const Communicator& ranks) {
  if (ranks.alone() || !losesCells(system, ranks)) return;
  const int axes = int(system.periodic[0]) + int(system.periodic[1]) + int(system.periodic[2]);
  log::warning(fmt::format(
      "HemoCell 2.7 can delete cells at periodic faces in the first iteration: with {} on {} ranks, ranks "
      "exchange "
      "particles across these faces more than once, and HemoCell then shifts them repeatedly. Run on one "
      "rank, {}, or "
      "correct HemoCell (Proposals to HemoCell, 9). To verify, call packmesh::verifyParticles(hemocell, "
      "loaded) after "
      "the first iterate()",
      axes == 1 ? "several atomic blocks per rank" : fmt::format("{} periodic axes", axes), ranks.size(),
      axes == 1 ? "with one atomic block per rank"
                : "call setSystemPeriodicity(axis, false) for all axes but one"));
}

}  // namespace packmesh::hemocell
