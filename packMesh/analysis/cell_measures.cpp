// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/analysis/cell_measures.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "packMesh/certificate/overlap_finder.h"
#include "packMesh/certificate/shared_cells.h"
#include "packMesh/shape/surface_distance.h"

namespace packmesh {
namespace {

/// Approximate edge of the boxes of the local hematocrit [µm], and the number of points along each axis that
/// sample how much of a box is lumen.
constexpr double edgeOfBoxes = 10.0;
constexpr int lumenPoints = 6;

/// Number of points in a cell over which its volume is distributed evenly.
constexpr int pointsOfCell = 64;

/// Limit of the first search for gaps [µm], and factor by which it grows. The gaps of almost all cells of a
/// dense packing are below the first.
constexpr double firstLevel = 0.08, levelGrowth = 4.0;

/// Volumes are summed as integer multiples of this [µm³], so that the sum does not depend on the order.
constexpr double volumeStep = 0x1p-20;

/// The lumen's bounding box, divided into boxes.
class Boxes {
 public:
  explicit Boxes(const Container& container) : bounds_(container.bounds()), period_(container.period()) {
    for (int k = 0; k < 3; ++k)
      count_[k] = std::max<std::int64_t>(1, std::llround((bounds_.hi[k] - bounds_.lo[k]) / edgeOfBoxes));
  }
  std::int64_t count() const { return count_[0] * count_[1] * count_[2]; }
  Vec3 size() const {
    const Vec3 all = bounds_.hi - bounds_.lo;
    return {all[0] / double(count_[0]), all[1] / double(count_[1]), all[2] / double(count_[2])};
  }
  std::int64_t of(const Vec3& p) const {
    std::int64_t at[3];
    for (int k = 0; k < 3; ++k) {
      double x = (p[k] - bounds_.lo[k]) / (bounds_.hi[k] - bounds_.lo[k]);
      if (period_[k] > 0.0) x -= std::floor(x);
      at[k] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(x * double(count_[k]))), 0,
                                       count_[k] - 1);
    }
    return (at[2] * count_[1] + at[1]) * count_[0] + at[0];
  }
  Vec3 corner(std::int64_t box) const {
    const Vec3 each = size();
    const std::int64_t x = box % count_[0], y = box / count_[0] % count_[1],
                       z = box / (count_[0] * count_[1]);
    return bounds_.lo + each.cwiseProduct(Vec3(double(x), double(y), double(z)));
  }

 private:
  Box bounds_;
  Vec3 period_;
  std::array<std::int64_t, 3> count_{};
};

/// Volume of the part of a box inside the lumen [µm³].
double lumenIn(const Boxes& boxes, std::int64_t box, const Wall* wall) {
  const Vec3 size = boxes.size(), corner = boxes.corner(box);
  if (!wall) return size.prod();
  int inside = 0;
  for (int i = 0; i < lumenPoints; ++i)
    for (int j = 0; j < lumenPoints; ++j)
      for (int k = 0; k < lumenPoints; ++k) {
        const Vec3 at = (Vec3(i, j, k).array() + 0.5) / lumenPoints;
        inside += wall->distance(corner + at.cwiseProduct(size)).distance > 0.0;
      }
  return size.prod() * std::max(inside, 1) / (lumenPoints * lumenPoints * lumenPoints);
}

class Measuring {
 public:
  Measuring(const Physics& physics, const Execution& execution, const CertificateInput& input,
            const std::vector<bool>& leftOut)
      : physics_(physics), execution_(execution), input_(input), leftOut_(leftOut), cells_(input_) {}

  CellMeasures operator()() const {
    const std::vector<std::atomic<double>> gaps = gapsOfAll();
    const std::vector<double> hematocrits = localHematocrits();
    CellMeasures own;
    for (std::int64_t i = 0; i < cells_.count(); ++i) {
      if (!cells_.isOwn(i)) continue;
      own.gap.push_back(gaps[i]);
      own.localHematocrit.push_back(hematocrits[i]);
    }
    return own;
  }

 private:
  const PlacedCell& cell(std::int64_t i) const { return (*input_.cells)[i]; }

  /// Calls visit(0 ... count - 1), shared among the threads.
  template <class Visit>
  void forEachCell(const Visit& visit) const {
    cells_.forEachPart(cells_.count(), [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i) visit(i);
    });
  }

  /// Gaps of own cells [µm]; upper bounds for the others. The search limit rises: gaps below the previous
  /// limit are known, so large distances are measured only for isolated cells. A gap below the limit is exact
  /// for any limit, so the result does not depend on the order.
  std::vector<std::atomic<double>> gapsOfAll() const {
    std::vector<std::atomic<double>> gaps(cells_.count());
    for (std::atomic<double>& gap : gaps) gap = input_.largestGap;
    const PeriodicNeighbors neighbors = cells_.neighbors();
    const std::vector<std::int32_t> order = neighbors.spatialOrder();
    std::vector<char> open(cells_.count());  // whether the gap is not known yet
    for (std::int64_t i = 0; i < cells_.count(); ++i) open[i] = cells_.isOwn(i);
    for (double known = 0.0, level = firstLevel; known < input_.largestGap; level *= levelGrowth) {
      level = std::min(level, input_.largestGap);
      forEachCell([&](std::int64_t i) {
        if (open[order[i]]) searchAround(order[i], neighbors, level, open, gaps);
      });
      known = level;
      for (std::int64_t i = 0; i < cells_.count(); ++i) open[i] = open[i] && !(gaps[i] < known);
    }
    return gaps;
  }

  /// Measures the gaps of an open cell below `level`; likely ones first, because they limit the search for
  /// others. Each pair of open cells is visited once.
  void searchAround(std::int64_t cell, const PeriodicNeighbors& neighbors, double level,
                    const std::vector<char>& open, std::vector<std::atomic<double>>& gaps) const {
    struct Candidate {
      double least;
      NearPair pair;
    };
    std::vector<Candidate> candidates;
    const auto wanted = [&](std::int64_t other) { return other >= cell || !open[other]; };
    neighbors.forEachNear(cell, level, wanted, [&](const NearPair& pair) {
      const double least = cells_.leastGap(pair);
      if (least < level) candidates.push_back({least, pair});
    });
    std::sort(candidates.begin(), candidates.end(),
              [](const Candidate& a, const Candidate& b) { return a.least < b.least; });
    const auto ofOpen = [&](std::int64_t i) { return open[i] ? gaps[i].load() : 0.0; };
    const auto lower = [](std::atomic<double>& gap, double to) {
      for (double now = gap; to < now && !gap.compare_exchange_weak(now, to);) {
      }
    };
    for (const auto& [least, pair] : candidates) {
      const double limit = std::min(level, std::max(ofOpen(pair.first), ofOpen(pair.second)));
      if (!(std::max(least, pair.apart) < limit)) continue;
      const double gap = cells_.relation(pair, limit).gap;
      lower(gaps[pair.first], gap);
      lower(gaps[pair.second], gap);
    }
  }

  /// Of own cells; 0 for the others.
  std::vector<double> localHematocrits() const {
    std::vector<char> isHere(physics_.shapes.size(), 0);
    for (std::int64_t i = 0; i < cells_.count(); ++i)
      if (cells_.isOwn(i)) isHere[cell(i).shape] = 1;
    std::vector<std::vector<Vec3>> points(isHere.size());
    const InnerPoints innerPoints(pointsOfCell);
    execution_.threads.forEach(std::int64_t(points.size()), [&](std::int64_t s, int) {
      if (isHere[s]) points[s] = innerPoints(*physics_.shapes[s]);
    });
    const Boxes boxes(*physics_.container);
    std::vector<std::atomic<std::int64_t>> redHere(boxes.count());  // [steps]
    forEachCell([&](std::int64_t i) {
      if (!cells_.isOwn(i) || !physics_.species[cell(i).species].inHematocrit) return;
      if (!leftOut_.empty() && leftOut_[i]) return;
      const std::vector<Vec3>& inCell = points[cell(i).shape];
      const auto each = std::llround(cells_.volume(i) / volumeStep / double(inCell.size()));
      for (const Vec3& p : inCell) redHere[boxes.of(cell(i).placement(p))] += each;
    });
    std::vector<std::int64_t> red(redHere.begin(), redHere.end());
    execution_.communicator.sum(red);
    std::vector<std::atomic<double>> hematocrit(red.size());  // computed when needed
    for (std::atomic<double>& h : hematocrit) h = -1.0;
    std::vector<double> local(cells_.count(), 0.0);
    forEachCell([&](std::int64_t i) {
      if (!cells_.isOwn(i)) return;
      const std::vector<Vec3>& inCell = points[cell(i).shape];
      for (const Vec3& p : inCell) {
        const std::int64_t box = boxes.of(cell(i).placement(p));
        double h = hematocrit[box];
        if (h < 0.0)
          hematocrit[box] = h =
              volumeStep * double(red[box]) / lumenIn(boxes, box, physics_.container->wall());
        local[i] += h / double(inCell.size());
      }
    });
    return local;
  }

  const Physics& physics_;
  const Execution& execution_;
  const CertificateInput& input_;
  const std::vector<bool>& leftOut_;
  const CertifiedCells cells_;
};

}  // namespace

std::size_t CellMeasures::size() const {
  std::size_t cells = gap.size();
  for (const Column& column : columns) cells = std::min(cells, (this->*column.values).size());
  return cells;
}

void CellMeasures::resize(std::size_t cells) {
  for (const Column& column : columns) (this->*column.values).resize(cells);
}

MeasuresOfCell measuresOfCell(const CellMeasures& measures, std::size_t cell) {
  MeasuresOfCell of;
  for (std::size_t c = 0; c < of.size(); ++c) of[c] = (measures.*CellMeasures::columns[c].values)[cell];
  return of;
}

void setMeasuresOfCell(CellMeasures& measures, std::size_t cell, const MeasuresOfCell& of) {
  for (std::size_t c = 0; c < of.size(); ++c) (measures.*CellMeasures::columns[c].values)[cell] = of[c];
}

CellMeasures measureCells(const Physics& physics, const Execution& execution, const CertificateInput& input,
                          const std::vector<bool>& leftOut) {
  return Measuring(physics, execution, input, leftOut)();
}

namespace {

struct Measured {
  int index;
  MeasuresOfCell of;
};

}  // namespace

CellMeasures measureShare(const Physics& physics, const Execution& execution,
                          const std::vector<PlacedCell>& own, const std::set<std::int64_t>& outside,
                          double largestGap) {
  const Communicator& ranks = execution.communicator;
  const SharedCells here = sharedInSpace(own, physics, largestGap, ranks);
  std::vector<bool> leftOut;
  for (const std::int64_t number : here.numbers) leftOut.push_back(outside.count(number) > 0);
  CertificateInput input = certificateInputOf(physics, here.cells, execution.threads);
  input.own = &here.own;
  input.largestGap = largestGap;
  const CellMeasures found = measureCells(physics, execution, input, leftOut);

  std::vector<std::vector<Measured>> back(ranks.size());
  std::size_t n = 0;
  for (std::size_t i = 0; i < here.cells.size(); ++i) {
    if (!here.own[i]) continue;
    back[here.origins[i].rank].push_back({here.origins[i].index, measuresOfCell(found, n)});
    ++n;
  }
  CellMeasures measures;
  measures.resize(own.size());
  for (const std::vector<Measured>& some : ranks.exchange(back))
    for (const Measured& one : some) setMeasuresOfCell(measures, one.index, one.of);
  return measures;
}

}  // namespace packmesh
