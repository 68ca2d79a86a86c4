// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/shared_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "packMesh/core/tolerances.h"
#include "packMesh/parallel/blocks.h"

namespace packmesh {
namespace {

/// A cell sent to a rank that examines it or one of its neighbours.
struct Traveller {
  PlacedCell cell;
  std::int64_t number;
  SharedCells::Origin origin;
  bool own;
};

/// That many of a rank's cells are sent at a time, so that messages need little memory.
constexpr std::int64_t atATime = 1 << 12;

void add(SharedCells& cells, const Traveller& one) {
  cells.cells.push_back(one.cell);
  cells.own.push_back(one.own);
  cells.numbers.push_back(one.number);
  cells.origins.push_back(one.origin);
}

void add(SharedCells& cells, const SharedCells& others) {
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  append(cells.cells, others.cells);
  append(cells.own, others.own);
  append(cells.numbers, others.numbers);
  append(cells.origins, others.origins);
}

/// Slices of the lumen across an axis.
class Slices {
 public:
  /// @param cuts between the slices, ascending
  Slices(std::vector<double> cuts, double begin, double end, double period)
      : borders_(std::move(cuts)), period_(period) {
    constexpr double endless = std::numeric_limits<double>::infinity();
    borders_.insert(borders_.begin(), period > 0.0 ? begin : -endless);
    borders_.push_back(period > 0.0 ? end : endless);
  }

  int of(double x) const {
    return static_cast<int>(std::upper_bound(borders_.begin() + 1, borders_.end() - 1, x) -
                            (borders_.begin() + 1));
  }

  /// True if `x` or one of its images is within `reach` [µm] of a slice.
  bool isNear(double x, int slice, double reach) const {
    for (const int image : {0, -1, 1}) {
      const double at = x + image * period_;
      if (at >= borders_[slice] - reach && at <= borders_[slice + 1] + reach) return true;
    }
    return false;
  }

 private:
  std::vector<double> borders_;
  double period_;
};

/// Numbers of slices across each axis whose product is `parts`, with the smallest faces between parts.
std::array<int, 3> slicesOf(const Container& container, int parts) {
  const Vec3 size = container.bounds().size(), period = container.period();
  std::array<int, 3> best{parts, 1, 1};
  double least = std::numeric_limits<double>::infinity();
  for (int x = 1; x <= parts; ++x)
    for (int y = 1; parts % x == 0 && y <= parts / x; ++y) {
      if (parts / x % y != 0) continue;
      const std::array<int, 3> n{x, y, parts / x / y};
      double faces = 0.0;
      for (int k = 0; k < 3; ++k)
        if (n[k] > 1) faces += (period[k] > 0.0 ? n[k] : n[k] - 1) * size[(k + 1) % 3] * size[(k + 2) % 3];
      if (faces < least) best = n;
      least = std::min(least, faces);
    }
  return best;
}

/// Parts of the lumen, one per rank.
class Parts {
 public:
  Parts(const Container& container, const std::vector<PlacedCell>& own, const Communicator& ranks)
      : bounds_(container.bounds()), period_(container.period()), count_(slicesOf(container, ranks.size())) {
    for (int k = 0; k < 3; ++k)
      slices_.emplace_back(cutsOf(k, own, ranks), bounds_.lo[k], bounds_.hi[k], period_[k]);
  }

  int of(const Vec3& p) const {
    const Vec3 q = wrapped(p, bounds_, period_);
    return rankOf(slices_[0].of(q[0]), slices_[1].of(q[1]), slices_[2].of(q[2]));
  }

  /// Calls visit(rank) for the parts near `p` or one of its images.
  template <class Visit>
  void forEachNear(const Vec3& p, double reach, Visit&& visit) const {
    const Vec3 q = wrapped(p, bounds_, period_);
    for (int z = 0; z < count_[2]; ++z) {
      if (!slices_[2].isNear(q[2], z, reach)) continue;
      for (int y = 0; y < count_[1]; ++y) {
        if (!slices_[1].isNear(q[1], y, reach)) continue;
        for (int x = 0; x < count_[0]; ++x)
          if (slices_[0].isNear(q[0], x, reach)) visit(rankOf(x, y, z));
      }
    }
  }

 private:
  int rankOf(int x, int y, int z) const { return (z * count_[1] + y) * count_[0] + x; }

  /// Between slices with as many cells each.
  std::vector<double> cutsOf(int axis, const std::vector<PlacedCell>& own, const Communicator& ranks) const {
    constexpr int bins = 4096;
    const double begin = bounds_.lo[axis], size = bounds_.size()[axis];
    std::vector<std::int64_t> cells(bins, 0);
    for (const PlacedCell& cell : own) {
      const double x = (wrapped(cell.placement.translation, bounds_, period_)[axis] - begin) / size;
      ++cells[static_cast<int>(std::clamp(x, 0.0, 1.0 - 1.0 / bins) * bins)];
    }
    ranks.sum(cells);
    std::int64_t all = 0, before = 0;
    for (const std::int64_t n : cells) all += n;
    std::vector<double> cuts;
    for (int bin = 0; bin < bins; ++bin) {
      before += cells[bin];
      while (static_cast<int>(cuts.size()) + 1 < count_[axis] &&
             before * count_[axis] >= all * (static_cast<std::int64_t>(cuts.size()) + 1))
        cuts.push_back(begin + size * (bin + 1) / bins);
    }
    return cuts;
  }

  Box bounds_;
  Vec3 period_;
  std::array<int, 3> count_;
  std::vector<Slices> slices_;
};

}  // namespace

SharedCells sharedInSpace(const std::vector<PlacedCell>& own, const Physics& physics, double largestGap,
                          const Communicator& ranks) {
  const Parts parts(*physics.container, own, ranks);
  double radius = 0.0;
  for (const auto& shape : physics.shapes) radius = std::max(radius, shape->radius());
  const double reach = 2.0 * radius + largestGap + tolerance::culling;
  const auto cells = static_cast<std::int64_t>(own.size());
  const std::int64_t first = ranks.sumBefore({cells}).front();
  std::vector<SharedCells> from(ranks.size());  // by rank of origin: each is sorted
  std::vector<std::vector<Traveller>> to(ranks.size());
  for (std::int64_t begin = 0; ranks.any(begin < cells); begin += atATime) {
    for (std::int64_t i = begin; i < std::min(begin + atATime, cells); ++i) {
      Traveller one{own[i], first + i, {ranks.rank(), static_cast<int>(i)}, false};
      const Vec3& center = own[i].placement.translation;
      const int owner = parts.of(center);
      parts.forEachNear(center, reach, [&](int rank) {
        one.own = rank == owner;
        if (!one.own) to[rank].push_back(one);
      });
      one.own = true;
      to[owner].push_back(one);
    }
    const std::vector<std::vector<Traveller>> received = ranks.exchange(to);
    for (int rank = 0; rank < ranks.size(); ++rank) {
      for (const Traveller& one : received[rank]) add(from[rank], one);
      to[rank].clear();
    }
  }
  for (int rank = 1; rank < ranks.size(); ++rank) {
    add(from[0], from[rank]);
    from[rank] = {};
  }
  return std::move(from[0]);
}

}  // namespace packmesh
