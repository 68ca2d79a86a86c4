// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

/// out &= in shifted by `shift` bits (positive: towards higher nodes), with ones shifted in at both ends.
void andShifted(std::vector<std::uint64_t>& out, const std::vector<std::uint64_t>& in, int shift) {
  const int count = static_cast<int>(in.size());
  const auto word = [&](int w) { return w < 0 || w >= count ? allBits : in[w]; };
  const int words = (shift >= 0 ? shift : shift - 63) / 64, bits = shift - 64 * words;  // bits in 0..63
  for (int w = 0; w < count; ++w)
    out[w] &= bits == 0 ? word(w - words) : word(w - words) << bits | word(w - words - 1) >> (64 - bits);
}

}  // namespace

Lattice::Lattice(std::array<int, 3> nodes, double dx) : nodes_(nodes), dx_(dx), wordsPerRow_(0) {
  if (!(dx > 0.0) || !std::isfinite(dx))
    throw InputError(fmt::format("lattice spacing {} µm: expected a positive length", dx));
  double count = 1.0;
  for (int n : nodes) {
    if (n < 1)
      throw InputError(fmt::format("a lattice of {} x {} x {} nodes: expected at least one on every axis",
                                   nodes[0], nodes[1], nodes[2]));
    count *= n;
  }
  if (count > mostNodes)
    throw InputError(fmt::format("a lattice of {} x {} x {} nodes: expected at most 2^31 in total", nodes[0],
                                 nodes[1], nodes[2]));
  wordsPerRow_ = (nodes[0] + 63) / 64;
  words_.resize(static_cast<std::size_t>(wordsPerRow_) * nodes[1] * nodes[2]);
  for (std::size_t w = 0; w < words_.size(); ++w)
    words_[w] = usedBits(nodes[0], static_cast<int>(w % wordsPerRow_));
}

void Lattice::setFluid(int i, int j, int k, bool fluid) {
  setFluid(i, i, j, k, fluid);
}

void Lattice::setFluid(int from, int to, int j, int k, bool fluid) {
  from = std::max(from, 0);
  to = std::min(to, nodes_[0] - 1);
  if (from > to) return;
  std::uint64_t* words = &words_[rowStart(j, k)];
  for (int w = from >> 6; w <= to >> 6; ++w) {
    std::uint64_t bits = allBits;
    if (w == from >> 6) bits &= allBits << (from & 63);
    if (w == to >> 6) bits &= allBits >> (63 - (to & 63));
    words[w] = fluid ? words[w] | bits : words[w] & ~bits;
  }
}

std::int64_t Lattice::fluidNodes() const {
  std::int64_t count = 0;
  for (std::uint64_t word : words_) count += __builtin_popcountll(word);
  return count;
}

bool Lattice::hasFluidNodes() const {
  return std::any_of(words_.begin(), words_.end(), [](std::uint64_t word) { return word != 0; });
}

std::optional<std::array<std::array<int, 3>, 2>> Lattice::fluidRange() const {
  std::array<int, 3> first = nodes_, last = {-1, -1, -1};
  for (int k = 0; k < nodes_[2]; ++k)
    for (int j = 0; j < nodes_[1]; ++j)
      for (int w = 0; w < wordsPerRow_; ++w) {
        const std::uint64_t bits = word(w, j, k);
        if (bits == 0) continue;
        const std::array<int, 3> low = {64 * w + __builtin_ctzll(bits), j, k},
                                 high = {64 * w + 63 - __builtin_clzll(bits), j, k};
        for (int a = 0; a < 3; ++a) {
          first[a] = std::min(first[a], low[a]);
          last[a] = std::max(last[a], high[a]);
        }
      }
  if (last[0] < 0) return {};
  return std::array<std::array<int, 3>, 2>{first, last};
}

double Lattice::fluidVolume() const {
  return static_cast<double>(fluidNodes()) * dx_ * dx_ * dx_;
}

Lattice Lattice::eroded(int radius) const {
  Lattice out = *this;
  if (radius <= 0) return out;
  const auto [nx, ny, nz] = nodes_;
  // One axis after the other, since the cube is the product of three intervals.
  std::vector<std::uint64_t> before(wordsPerRow_), after(wordsPerRow_);
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j) {
      for (int w = 0; w < wordsPerRow_; ++w) before[w] = row(j, k)[w] | ~usedBits(nx, w);
      after = before;
      for (int shift = 1; shift <= std::min(radius, nx); ++shift) {
        andShifted(after, before, shift);
        andShifted(after, before, -shift);
      }
      for (int w = 0; w < wordsPerRow_; ++w) out.words_[rowStart(j, k) + w] = after[w] & usedBits(nx, w);
    }
  for (int axis = 1; axis <= 2; ++axis) {
    const Lattice in = out;
    for (int k = 0; k < nz; ++k)
      for (int j = 0; j < ny; ++j) {
        const int at = axis == 1 ? j : k;
        std::uint64_t* words = &out.words_[rowStart(j, k)];
        for (int other = std::max(0, at - radius); other <= std::min(nodes_[axis] - 1, at + radius);
             ++other) {
          const std::uint64_t* row = axis == 1 ? in.row(other, k) : in.row(j, other);
          for (int w = 0; w < wordsPerRow_; ++w) words[w] &= row[w];
        }
      }
  }
  return out;
}

Lattice Lattice::repeated(const std::array<int, 3>& margin) const {
  std::array<int, 3> extended = nodes_;
  for (int k = 0; k < 3; ++k) extended[k] += 2 * margin[k];
  Lattice out(extended, dx_);
  const auto wrapped = [&](int i, int k) { return (((i - margin[k]) % nodes_[k]) + nodes_[k]) % nodes_[k]; };
  for (int k = 0; k < extended[2]; ++k)
    for (int j = 0; j < extended[1]; ++j) {
      const std::uint64_t* from = row(wrapped(j, 1), wrapped(k, 2));
      for (int w = 0; w < out.wordsPerRow_; ++w) {
        const int count = std::min(64, extended[0] - 64 * w);
        std::uint64_t& to = out.words_[out.rowStart(j, k) + w] = 0;
        for (int bit = 0; bit < count;) {  // runs of bits that lie in one word of this lattice
          const int i = wrapped(64 * w + bit, 0), run = std::min({count - bit, nodes_[0] - i, 64 - (i & 63)});
          to |= (from[i >> 6] >> (i & 63) & usedBits(run, 0)) << bit;
          bit += run;
        }
      }
    }
  return out;
}

}  // namespace packmesh::hemocell
