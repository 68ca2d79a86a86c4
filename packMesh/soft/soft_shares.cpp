// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/soft_shares.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace packmesh {
namespace {

/// Divides cells among ranks by planes across the longest axis of the box around their centres, again and
/// again: few cells are near those of other ranks (recursive coordinate bisection: Berger and Bokhari, IEEE
/// Trans. Comput. 36, 570, 1987).
class Bisection {
 public:
  Bisection(const std::vector<Vec3>& centers, const std::vector<std::int64_t>& work, int ranks)
      : centers_(centers), work_(work), owner_(centers.size(), 0) {
    std::vector<int> all(centers.size());
    std::iota(all.begin(), all.end(), 0);
    divide(all.begin(), all.end(), 0, ranks);
  }
  std::vector<int> owners() && { return std::move(owner_); }

 private:
  using At = std::vector<int>::iterator;

  void divide(At begin, At end, int firstRank, int ranks) {
    if (ranks == 1 || begin == end) {
      for (At at = begin; at != end; ++at) owner_[*at] = firstRank;
      return;
    }
    Box box;
    std::int64_t work = 0;
    for (At at = begin; at != end; ++at) {
      box.add(centers_[*at]);
      work += work_[*at];
    }
    int axis = 0;
    box.size().maxCoeff(&axis);
    std::sort(begin, end, [&](int a, int b) {
      return std::pair(centers_[a][axis], a) < std::pair(centers_[b][axis], b);
    });
    const int before = ranks / 2;
    const double share = double(work) * before / ranks;
    At cut = begin;
    for (double sum = 0.0; cut != end && sum + 0.5 * double(work_[*cut]) <= share; ++cut)
      sum += double(work_[*cut]);
    divide(begin, cut, firstRank, before);
    divide(cut, end, firstRank + before, ranks - before);
  }

  const std::vector<Vec3>& centers_;
  const std::vector<std::int64_t>& work_;
  std::vector<int> owner_;
};

void sortOnce(std::vector<int>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

}  // namespace

SoftNeighbors nearBoxes(const std::vector<Box>& boxes, const Vec3& period, double reach,
                        const Threads& threads) {
  struct Image {
    int cell;
    Vec3 shift;
    Box box;
  };
  Box bounds;
  for (const Box& box : boxes) bounds.add(box);
  std::vector<Image> images;
  double longest = 0.0;  // along x
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Box& box = boxes[i];
    int first[3] = {0, 0, 0}, last[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
      if (period[k] <= 0.0) continue;
      first[k] = int(std::ceil((bounds.lo[k] - reach - box.hi[k]) / period[k]));
      last[k] = int(std::floor((bounds.hi[k] + reach - box.lo[k]) / period[k]));
    }
    longest = std::max(longest, box.size().x());
    for (int x = first[0]; x <= last[0]; ++x)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int z = first[2]; z <= last[2]; ++z) {
          const Vec3 shift = Vec3(x, y, z).cwiseProduct(period);
          images.push_back({int(i), shift, {box.lo + shift, box.hi + shift}});
        }
  }
  std::stable_sort(images.begin(), images.end(),
                   [](const Image& a, const Image& b) { return a.box.lo.x() < b.box.lo.x(); });
  SoftNeighbors near(boxes.size());
  threads.forEach(std::int64_t(boxes.size()), [&](std::int64_t i, int) {
    const Box wanted = boxes[i].grownBy(reach);
    auto at = std::lower_bound(images.begin(), images.end(), wanted.lo.x() - longest,
                               [](const Image& image, double x) { return image.box.lo.x() < x; });
    for (; at != images.end() && at->box.lo.x() <= wanted.hi.x(); ++at)
      if (at->box.meets(wanted)) near[i].emplace_back(at->cell, at->shift);
    std::sort(near[i].begin(), near[i].end(), [](const auto& p, const auto& q) {
      return std::tuple(p.first, p.second[0], p.second[1], p.second[2]) <
             std::tuple(q.first, q.second[0], q.second[1], q.second[2]);
    });
  });
  return near;
}

SoftShares::SoftShares(const std::vector<Vec3>& centers, const std::vector<std::int64_t>& work,
                       const Communicator& ranks)
    : ranks_(ranks),
      team_(centers.size() > few ? ranks : Communicator()),
      owner_(Bisection(centers, work, team_.size()).owners()),
      sends_(ranks.size()),
      receives_(ranks.size()),
      sent_(ranks.size()) {
  for (std::size_t i = 0; i < owner_.size(); ++i)
    if (isMine(i)) mine_.push_back(int(i));
}

void SoftShares::find(const SoftNeighbors& near) {
  if (team_.alone()) return;
  sends_.assign(ranks_.size(), {});
  receives_.assign(ranks_.size(), {});
  const auto need = [&](int cell, int other) {  // the rank of the first needs the other
    if (isMine(cell)) receives_[owner_[other]].push_back(other);
    if (isMine(other)) sends_[owner_[cell]].push_back(other);
  };
  for (std::size_t i = 0; i < near.size(); ++i)
    for (const auto& [j, shift] : near[i]) {
      if (owner_[i] == owner_[j]) continue;
      need(int(i), j);
      need(j, int(i));
    }
  others_.clear();
  for (std::vector<int>& cells : sends_) sortOnce(cells);
  for (std::vector<int>& cells : receives_) {
    sortOnce(cells);
    others_.insert(others_.end(), cells.begin(), cells.end());
  }
  std::sort(others_.begin(), others_.end());
}

void SoftShares::exchange(const Pack& pack, const Unpack& unpack) {
  if (team_.alone()) return;
  for (std::size_t rank = 0; rank < sends_.size(); ++rank) {
    sent_[rank].clear();
    for (const int i : sends_[rank]) pack(i, sent_[rank]);
  }
  ranks_.exchange(sent_, received_);
  for (std::size_t rank = 0; rank < receives_.size(); ++rank) {
    const float* from = received_[rank].data();
    for (const int i : receives_[rank]) from = unpack(i, from);
  }
}

void SoftShares::gather(const Pack& pack, const Unpack& unpack) const {
  if (ranks_.alone()) return;
  std::vector<float> own;
  for (const int i : mine_) pack(i, own);
  const std::vector<float> all = ranks_.gatherAll(own);
  const float* from = all.data();
  for (int rank = 0; rank < ranks_.size(); ++rank)
    for (std::size_t i = 0; i < owner_.size(); ++i)
      if (owner_[i] == rank) from = unpack(int(i), from);
}

}  // namespace packmesh
