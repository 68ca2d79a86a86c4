// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/lattice_view.h"

#include <algorithm>
#include <utility>

namespace packmesh::hemocell {
namespace {

class ErodedView final : public LatticeView {
 public:
  ErodedView(std::shared_ptr<const LatticeView> of, int radius)
      : LatticeView(of->nodes()), of_(std::move(of)), radius_(radius) {}

  std::uint64_t word(int w, int j, int k) const override {
    std::uint64_t before = allBits, here = allBits, after = allBits;
    for (int c = k - radius_; c <= k + radius_; ++c)
      for (int b = j - radius_; b <= j + radius_; ++b) {
        here &= source(w, b, c);
        if (here == 0) return 0;
        before &= source(w - 1, b, c);
        after &= source(w + 1, b, c);
      }
    std::uint64_t result = here;
    for (int shift = 1; shift <= std::min(radius_, 63); ++shift)
      result &= (here >> shift | after << (64 - shift)) & (here << shift | before >> (64 - shift));
    return result & usedBits(nodes()[0], w);
  }

 private:
  /// A word of the other lattice; nodes that do not exist are not solid.
  std::uint64_t source(int w, int j, int k) const {
    const std::array<int, 3>& n = nodes();
    if (w < 0 || w >= wordsPerRow() || j < 0 || j >= n[1] || k < 0 || k >= n[2]) return allBits;
    return of_->word(w, j, k) | ~usedBits(n[0], w);
  }

  std::shared_ptr<const LatticeView> of_;
  int radius_;
};

class RepeatedView final : public LatticeView {
 public:
  RepeatedView(std::shared_ptr<const LatticeView> of, const std::array<int, 3>& margin)
      : LatticeView(extended(of->nodes(), margin)), of_(std::move(of)), margin_(margin) {}

  std::uint64_t word(int w, int j, int k) const override {
    const int y = wrapped(j - margin_[1], 1), z = wrapped(k - margin_[2], 2);
    const int count = std::min(64, nodes()[0] - 64 * w);
    std::uint64_t result = 0;
    for (int bit = 0; bit < count;) {  // runs of bits that lie in one word of the other lattice
      const int x = wrapped(64 * w + bit - margin_[0], 0);
      const int run = std::min({count - bit, of_->nodes()[0] - x, 64 - (x & 63)});
      const std::uint64_t bits = of_->word(x >> 6, y, z) >> (x & 63);
      result |= (run == 64 ? bits : bits & ((std::uint64_t(1) << run) - 1)) << bit;
      bit += run;
    }
    return result;
  }

 private:
  static std::array<int, 3> extended(std::array<int, 3> nodes, const std::array<int, 3>& margin) {
    for (int a = 0; a < 3; ++a) nodes[a] += 2 * margin[a];
    return nodes;
  }
  int wrapped(int i, int axis) const {
    const int n = of_->nodes()[axis];
    return ((i % n) + n) % n;
  }

  std::shared_ptr<const LatticeView> of_;
  std::array<int, 3> margin_;
};

}  // namespace

std::shared_ptr<const LatticeView> erodedView(std::shared_ptr<const LatticeView> of, int radius) {
  return std::make_shared<ErodedView>(std::move(of), radius);
}

std::shared_ptr<const LatticeView> repeatedView(std::shared_ptr<const LatticeView> of,
                                                const std::array<int, 3>& margin) {
  return std::make_shared<RepeatedView>(std::move(of), margin);
}

}  // namespace packmesh::hemocell
