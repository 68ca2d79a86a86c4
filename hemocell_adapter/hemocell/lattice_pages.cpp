// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/lattice_pages.h"

#include <algorithm>
#include <atomic>
#include <utility>
#include <vector>

namespace packmesh::hemocell {
namespace {

constexpr std::uint64_t allBits = ~std::uint64_t(0);
constexpr int blocksPerPage = LatticePages::nodesX / LatticePages::blockNodes;

/// The nodes of a word that exist, as bits.
std::uint64_t existing(int nodes, int w) {
  const int used = nodes - 64 * w;
  return used >= 64 ? allBits : used <= 0 ? 0 : (std::uint64_t(1) << used) - 1;
}

std::array<int, 3> blocksOf(const std::array<int, 3>& nodes) {
  std::array<int, 3> blocks;
  for (int a = 0; a < 3; ++a)
    blocks[a] = (nodes[a] + LatticePages::blockNodes - 1) / LatticePages::blockNodes;
  return blocks;
}

/// Classifies blocks: classify(block) returns whether all and whether any of its nodes are fluid.
template <class Classify>
CoarseNodes classified(const std::array<int, 3>& nodes, const Classify& classify) {
  const std::array<int, 3> blocks = blocksOf(nodes);
  const auto all = std::make_shared<BlockFlagsOfLattice>(blocks),
             any = std::make_shared<BlockFlagsOfLattice>(blocks);
  for (int k = 0; k < blocks[2]; ++k)
    for (int j = 0; j < blocks[1]; ++j)
      for (int i = 0; i < blocks[0]; ++i) {
        const auto [isAll, isAny] = classify(std::array<int, 3>{i, j, k});
        all->setFluid(i, j, k, isAll);
        any->setFluid(i, j, k, isAny);
      }
  return {all, any};
}

/// Whether the block lies in the lattice with all its nodes.
bool isWhole(const std::array<int, 3>& block, const std::array<int, 3>& nodes) {
  for (int a = 0; a < 3; ++a)
    if ((block[a] + 1) * LatticePages::blockNodes > nodes[a]) return false;
  return true;
}

/// Whether every (or any) block from first to last that exists satisfies a condition.
template <class Condition>
bool everyBlock(const std::array<int, 3>& first, const std::array<int, 3>& last, const Condition& condition) {
  for (int k = first[2]; k <= last[2]; ++k)
    for (int j = first[1]; j <= last[1]; ++j)
      for (int i = first[0]; i <= last[0]; ++i)
        if (!condition(i, j, k)) return false;
  return true;
}

class ErodedPages final : public LatticePages {
 public:
  ErodedPages(std::shared_ptr<const LatticePages> of, int radius)
      : LatticePages(of->nodes()), of_(std::move(of)), radius_(radius) {
    const std::array<int, 3> blocks = blocksOf(nodes());
    const int reach = (radius + blockNodes - 1) / blockNodes;
    coarse_ = classified(nodes(), [&](const std::array<int, 3>& block) {
      std::array<int, 3> first, last;
      for (int a = 0; a < 3; ++a) {
        first[a] = std::max(0, block[a] - reach);
        last[a] = std::min(blocks[a] - 1, block[a] + reach);
      }
      const bool all = isWhole(block, nodes()) && everyBlock(first, last, [&](int i, int j, int k) {
                         return of_->coarse().all->fluid(i, j, k);
                       });
      return std::pair<bool, bool>{all, of_->coarse().any->fluid(block[0], block[1], block[2])};
    });
  }

 protected:
  void make(const std::array<int, 3>& page, LatticePage& out) const override {
    const int w = page[0];
    for (int k = 0; k < nodesYZ; ++k)
      for (int j = 0; j < nodesYZ; ++j)
        out[j + nodesYZ * k] = eroded(w, nodesYZ * page[1] + j, nodesYZ * page[2] + k);
  }

 private:
  /// A word of the other lattice; nodes that do not exist are not solid.
  std::uint64_t source(int w, int j, int k) const {
    const std::array<int, 3>& n = nodes();
    if (w < 0 || w >= count()[0] || j < 0 || j >= n[1] || k < 0 || k >= n[2]) return allBits;
    return of_->word(w, j, k) | ~existing(n[0], w);
  }

  std::uint64_t eroded(int w, int j, int k) const {
    if (j >= nodes()[1] || k >= nodes()[2]) return 0;
    std::uint64_t before = allBits, here = allBits, after = allBits;
    for (int c = k - radius_; c <= k + radius_; ++c)
      for (int b = j - radius_; b <= j + radius_; ++b) {
        before &= source(w - 1, b, c);
        here &= source(w, b, c);
        after &= source(w + 1, b, c);
      }
    std::uint64_t result = here;
    for (int shift = 1; shift <= std::min(radius_, 63); ++shift)
      result &= (here >> shift | after << (64 - shift)) & (here << shift | before >> (64 - shift));
    return result & existing(nodes()[0], w);
  }

  std::shared_ptr<const LatticePages> of_;
  int radius_;
};

class RepeatedPages final : public LatticePages {
 public:
  RepeatedPages(std::shared_ptr<const LatticePages> of, const std::array<int, 3>& margin)
      : LatticePages(extended(of->nodes(), margin)), of_(std::move(of)), margin_(margin) {
    coarse_ = classified(nodes(), [&](const std::array<int, 3>& block) {
      const std::array<std::vector<int>, 3> sources = {sourceBlocks(block[0], 0), sourceBlocks(block[1], 1),
                                                       sourceBlocks(block[2], 2)};
      bool all = isWhole(block, nodes()), any = false;
      for (const int k : sources[2])
        for (const int j : sources[1])
          for (const int i : sources[0]) {
            all = all && of_->coarse().all->fluid(i, j, k);
            any = any || of_->coarse().any->fluid(i, j, k);
          }
      return std::pair<bool, bool>{all, any};
    });
  }

 protected:
  void make(const std::array<int, 3>& page, LatticePage& out) const override {
    for (int k = 0; k < nodesYZ; ++k)
      for (int j = 0; j < nodesYZ; ++j) {
        const int y = nodesYZ * page[1] + j, z = nodesYZ * page[2] + k;
        std::uint64_t& word = out[j + nodesYZ * k];
        word = 0;
        if (y >= nodes()[1] || z >= nodes()[2]) continue;
        for (int bit = 0, i = 64 * page[0]; bit < 64 && i < nodes()[0]; ++bit, ++i) {
          const int x = wrapped(i - margin_[0], 0);
          word |= (of_->word(x >> 6, wrapped(y - margin_[1], 1), wrapped(z - margin_[2], 2)) >> (x & 63) & 1u)
                  << bit;
        }
      }
  }

 private:
  static std::array<int, 3> extended(std::array<int, 3> nodes, const std::array<int, 3>& margin) {
    for (int a = 0; a < 3; ++a) nodes[a] += 2 * margin[a];
    return nodes;
  }
  /// The blocks of the other lattice that have the nodes of a block along an axis.
  std::vector<int> sourceBlocks(int block, int axis) const {
    std::vector<int> sources;
    for (int i = block * blockNodes; i < std::min((block + 1) * blockNodes, nodes()[axis]); ++i) {
      const int source = wrapped(i - margin_[axis], axis) / blockNodes;
      if (sources.empty() || sources.back() != source) sources.push_back(source);
    }
    return sources;
  }
  int wrapped(int i, int axis) const {
    const int n = of_->nodes()[axis];
    return ((i % n) + n) % n;
  }

  std::shared_ptr<const LatticePages> of_;
  std::array<int, 3> margin_;
};

}  // namespace

std::uint64_t LatticePages::newName() {
  static std::atomic<std::uint64_t> names{0};
  return ++names;
}

const LatticePage& LatticePages::pageAt(const std::array<int, 3>& page) const {
  // Successive words mostly come from the same page.
  struct Last {
    std::uint64_t name = 0;
    std::int64_t number = 0;
    const LatticePage* page = nullptr;
  };
  thread_local std::array<Last, 4> lasts;
  const std::int64_t at = number(page);
  Last& last = lasts[name_ % lasts.size()];
  if (last.name != name_ || last.number != at) last = {name_, at, &found(page)};
  return *last.page;
}

const LatticePage& LatticePages::found(const std::array<int, 3>& page) const {
  // Most pages are uniform and need no copy.
  static const LatticePage solid{}, fluid = [] {
    LatticePage all;
    all.fill(allBits);
    return all;
  }();
  bool all = true, any = false;
  for (int i = blocksPerPage * page[0]; i < blocksPerPage * (page[0] + 1); ++i) {
    const bool exists = i < coarse_.all->blocks[0];
    all = all && exists && coarse_.all->fluid(i, page[1], page[2]);
    any = any || (exists && coarse_.any->fluid(i, page[1], page[2]));
  }
  if (all || !any) return all ? fluid : solid;
  return pages_.at(number(page), [&] {
    LatticePage made;
    make(page, made);
    return made;
  });
}

std::shared_ptr<const LatticePages> erodedPages(std::shared_ptr<const LatticePages> of, int radius) {
  return std::make_shared<ErodedPages>(std::move(of), radius);
}

std::shared_ptr<const LatticePages> repeatedPages(std::shared_ptr<const LatticePages> of,
                                                  const std::array<int, 3>& margin) {
  return std::make_shared<RepeatedPages>(std::move(of), margin);
}

}  // namespace packmesh::hemocell
