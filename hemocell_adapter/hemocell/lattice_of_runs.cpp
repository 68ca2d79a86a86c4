// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/lattice_of_runs.h"

#include <algorithm>

#include "hemocell_adapter/hemocell/lattice_view.h"
#include "packMesh/core/error.h"
#include "packMesh/parallel/node_memory.h"

namespace packmesh::hemocell {
namespace {

class NodesOfRuns final : public LatticeView {
 public:
  NodesOfRuns(const std::array<int, 3>& nodes, const std::vector<FluidRun>& runs, const Communicator& ranks,
              int ranksPerNode)
      : LatticeView(nodes),
        words_(ranks, std::size_t(wordsPerRow()) * nodes[1] * nodes[2], wordsOf(runs), ranksPerNode) {}

  std::uint64_t word(int w, int j, int k) const override { return words_[at(w, j, k)]; }

 private:
  std::size_t at(int w, int j, int k) const {
    return w + std::size_t(wordsPerRow()) * (j + std::size_t(nodes()[1]) * k);
  }
  NodeMemory::Words wordsOf(const std::vector<FluidRun>& runs) const {
    NodeMemory::Words words;
    for (const FluidRun& run : runs)
      for (int w = run.from >> 6; w <= run.to >> 6; ++w)
        words.emplace_back(at(w, run.j, run.k), bitsBetween(run.from, run.to, w));
    return words;
  }

  NodeMemory words_;
};

/// The corners of the box around the runs of all ranks.
std::array<std::array<int, 3>, 2> rangeOf(const std::array<int, 3>& nodes, const std::vector<FluidRun>& runs,
                                          const Communicator& ranks) {
  std::array<std::array<int, 3>, 2> range = {nodes, {-1, -1, -1}};
  for (const FluidRun& run : runs) {
    const std::array<int, 3> first = {run.from, run.j, run.k}, last = {run.to, run.j, run.k};
    for (int a = 0; a < 3; ++a) {
      range[0][a] = std::min(range[0][a], first[a]);
      range[1][a] = std::max(range[1][a], last[a]);
    }
  }
  for (int a = 0; a < 3; ++a) {
    range[0][a] = static_cast<int>(ranks.min(std::int64_t(range[0][a])));
    range[1][a] = static_cast<int>(-ranks.min(std::int64_t(-range[1][a])));
  }
  return range;
}

}  // namespace

std::shared_ptr<const Lattice> latticeOfRuns(const std::array<int, 3>& nodes, double dx,
                                             const std::vector<FluidRun>& runs, const Communicator& ranks,
                                             std::int64_t mostOnEveryRank, int ranksPerNode) {
  if (std::int64_t(nodes[0]) * nodes[1] * nodes[2] <= mostOnEveryRank) {
    auto lattice = std::make_shared<Lattice>(nodes, dx);
    for (int k = 0; k < nodes[2]; ++k)
      for (int j = 0; j < nodes[1]; ++j) lattice->setFluid(0, nodes[0] - 1, j, k, false);
    for (const FluidRun& run : ranks.gatherAll(runs)) lattice->setFluid(run.from, run.to, run.j, run.k, true);
    return lattice;
  }
  std::int64_t fluid = 0;
  for (const FluidRun& run : runs) fluid += run.to - run.from + 1;
  fluid = ranks.sum(fluid);
  if (fluid == 0) throw InputError("the lumen has no fluid node");
  auto lattice = std::make_shared<Lattice>(
      std::make_shared<const NodesOfRuns>(nodes, runs, ranks, ranksPerNode), dx, fluid);
  lattice->setFluidRange(rangeOf(nodes, runs, ranks));
  return lattice;
}

}  // namespace packmesh::hemocell
