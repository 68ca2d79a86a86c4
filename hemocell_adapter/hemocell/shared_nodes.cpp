// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/shared_nodes.h"

#include <algorithm>
#include <map>

#include "packMesh/core/error.h"
#include "packMesh/parallel/shared_pages.h"

namespace packmesh::hemocell {
namespace {

/// A part of a page, from one rank.
struct PagePart {
  std::int64_t number;
  LatticePage words;
};

/// Whether all and whether any of the nodes of the blocks of a page are fluid.
struct BlockFlags {
  unsigned char all[8], any[8];
};

BlockFlags flagsOf(const LatticePage& page) {
  BlockFlags flags{};
  for (int b = 0; b < 8; ++b) {
    std::uint64_t every = 0xff, some = 0;
    for (const std::uint64_t word : page) {
      const std::uint64_t bits = word >> (8 * b) & 0xff;
      every &= bits;
      some |= bits;
    }
    flags.all[b] = every == 0xff;
    flags.any[b] = some != 0;
  }
  return flags;
}

class SharedNodes final : public LatticePages {
 public:
  SharedNodes(const std::array<int, 3>& nodes, const std::vector<FluidRun>& runs, const Communicator& ranks)
      : LatticePages(nodes) {
    const std::int64_t pages = std::int64_t(count()[0]) * count()[1] * count()[2];
    const std::int64_t first = SharedPages::firstOf(ranks.rank(), pages, ranks.size()),
                       end = SharedPages::firstOf(ranks.rank() + 1, pages, ranks.size());
    std::vector<std::uint64_t> own(static_cast<std::size_t>(end - first) * LatticePage().size(), 0);
    for (const std::vector<PagePart>& parts : ranks.exchange(partsFor(runs, pages, ranks)))
      for (const PagePart& part : parts)
        for (std::size_t w = 0; w < part.words.size(); ++w)
          own[static_cast<std::size_t>(part.number - first) * part.words.size() + w] |= part.words[w];
    std::vector<BlockFlags> flags;
    for (std::int64_t page = first; page < end; ++page) {
      LatticePage words;
      std::copy_n(&own[static_cast<std::size_t>(page - first) * words.size()], words.size(), words.begin());
      flags.push_back(flagsOf(words));
    }
    classify(ranks.gatherAll(flags));
    shared_ =
        std::make_unique<SharedPages>(ranks, pages, static_cast<int>(LatticePage().size()), std::move(own));
  }

 protected:
  void make(const std::array<int, 3>& page, LatticePage& out) const override {
    shared_->read(number(page), out.data());
  }

 private:
  std::vector<std::vector<PagePart>> partsFor(const std::vector<FluidRun>& runs, std::int64_t pages,
                                              const Communicator& ranks) const {
    std::map<std::int64_t, LatticePage> mine;
    for (const FluidRun& run : runs)
      for (int w = run.from >> 6; w <= run.to >> 6; ++w) {
        LatticePage& page = mine[number({w, run.j / nodesYZ, run.k / nodesYZ})];
        std::uint64_t bits = ~std::uint64_t(0);
        if (w == run.from >> 6) bits &= ~std::uint64_t(0) << (run.from & 63);
        if (w == run.to >> 6) bits &= ~std::uint64_t(0) >> (63 - (run.to & 63));
        page[(run.j % nodesYZ) + nodesYZ * (run.k % nodesYZ)] |= bits;
      }
    std::vector<std::vector<PagePart>> to(ranks.size());
    for (const auto& [number, words] : mine)
      to[SharedPages::ownerOf(number, pages, ranks.size())].push_back({number, words});
    return to;
  }

  void classify(const std::vector<BlockFlags>& flags) {
    std::array<int, 3> blocks;
    for (int a = 0; a < 3; ++a) blocks[a] = (nodes()[a] + blockNodes - 1) / blockNodes;
    const auto all = std::make_shared<BlockFlagsOfLattice>(blocks),
               any = std::make_shared<BlockFlagsOfLattice>(blocks);
    for (int k = 0; k < blocks[2]; ++k)
      for (int j = 0; j < blocks[1]; ++j)
        for (int i = 0; i < blocks[0]; ++i) {
          const BlockFlags& page = flags[number({i / 8, j, k})];
          all->setFluid(i, j, k, page.all[i % 8]);
          any->setFluid(i, j, k, page.any[i % 8]);
        }
    coarse_ = {all, any};
  }

  std::unique_ptr<const SharedPages> shared_;
};

}  // namespace

std::shared_ptr<const Lattice> latticeOfRuns(const std::array<int, 3>& nodes, double dx,
                                             const std::vector<FluidRun>& runs, const Communicator& ranks,
                                             std::int64_t mostOnEveryRank) {
  if (std::int64_t(nodes[0]) * nodes[1] * nodes[2] <= mostOnEveryRank) {
    auto lattice = std::make_shared<Lattice>(nodes, dx);
    for (int k = 0; k < nodes[2]; ++k)
      for (int j = 0; j < nodes[1]; ++j) lattice->setFluid(0, nodes[0] - 1, j, k, false);
    for (const FluidRun& run : ranks.gatherAll(runs)) lattice->setFluid(run.from, run.to, run.j, run.k, true);
    return lattice;
  }
  std::int64_t fluid = 0;
  std::array<std::array<int, 3>, 2> range = {nodes, {-1, -1, -1}};
  for (const FluidRun& run : runs) {
    fluid += run.to - run.from + 1;
    const std::array<int, 3> first = {run.from, run.j, run.k}, last = {run.to, run.j, run.k};
    for (int a = 0; a < 3; ++a) {
      range[0][a] = std::min(range[0][a], first[a]);
      range[1][a] = std::max(range[1][a], last[a]);
    }
  }
  fluid = ranks.sum(fluid);
  if (fluid == 0) throw InputError("the lumen has no fluid node");
  for (int a = 0; a < 3; ++a) {
    range[0][a] = static_cast<int>(ranks.min(std::int64_t(range[0][a])));
    range[1][a] = static_cast<int>(-ranks.min(std::int64_t(-range[1][a])));
  }
  auto lattice =
      std::make_shared<Lattice>(std::make_shared<const SharedNodes>(nodes, runs, ranks), dx, fluid);
  lattice->setFluidRange(range);
  return lattice;
}

}  // namespace packmesh::hemocell
