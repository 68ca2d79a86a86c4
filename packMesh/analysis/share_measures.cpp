// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/analysis/share_measures.h"

#include <algorithm>
#include <cmath>

#include "packMesh/analysis/cell_measures.h"
#include "packMesh/parallel/periodic_images.h"

namespace packmesh {
namespace {

/// A cell sent to a rank that measures it or one of its neighbours.
struct Traveller {
  std::int64_t id;
  int from, index;  ///< rank of origin and index there
  int species;
  bool own;
  double linear[9], translation[3];

  PlacedCell cell() const {
    return {species, {Eigen::Map<const Mat3>(linear), Eigen::Map<const Vec3>(translation)}};
  }
};

struct Measured {
  int index;
  double gap, localHematocrit;
};

/// Slices of the lumen across its longest axis, one per rank.
class Slices {
 public:
  Slices(const Container& container, int count)
      : bounds_(container.bounds()), period_(container.period()), count_(count) {
    bounds_.size().maxCoeff(&axis_);
    width_ = bounds_.size()[axis_] / count;
  }

  int of(const Vec3& p) const {
    const double x = wrapped(p, bounds_, period_)[axis_] - bounds_.lo[axis_];
    return std::clamp(static_cast<int>(std::floor(x / width_)), 0, count_ - 1);
  }

  /// True if `p` or one of its images is within `reach` [µm] of a slice.
  bool isNear(const Vec3& p, int slice, double reach) const {
    const double x = wrapped(p, bounds_, period_)[axis_] - bounds_.lo[axis_];
    for (const int image : {0, -1, 1}) {
      const double at = x + image * period_[axis_];
      if (at >= slice * width_ - reach && at <= (slice + 1) * width_ + reach) return true;
    }
    return false;
  }

 private:
  Box bounds_;
  Vec3 period_;
  int count_, axis_ = 0;
  double width_ = 0.0;
};

/// The cells in each rank's slice and their neighbours, sorted by id.
std::vector<Traveller> sentToSlices(const AnalysisInput& analysis, const std::vector<PlacedCell>& own) {
  const Communicator& ranks = analysis.communicator;
  const Slices slices(*analysis.container, ranks.size());
  double radius = 0.0;
  for (const Shape* shape : analysis.shapes) radius = std::max(radius, shape->radius());
  const double reach = 2.0 * radius + farthestGap;
  std::int64_t id = ranks.sumBefore({static_cast<std::int64_t>(own.size())}).front();
  std::vector<std::vector<Traveller>> to(ranks.size());
  for (std::size_t i = 0; i < own.size(); ++i, ++id) {
    Traveller one{};
    one.id = id;
    one.from = ranks.rank();
    one.index = static_cast<int>(i);
    one.species = own[i].species;
    const Placement& placement = own[i].placement;
    Eigen::Map<Mat3>(one.linear) = placement.linear;
    Eigen::Map<Vec3>(one.translation) = placement.translation;
    const int owner = slices.of(placement.translation);
    for (int slice = 0; slice < ranks.size(); ++slice) {
      one.own = slice == owner;
      if (one.own || slices.isNear(placement.translation, slice, reach)) to[slice].push_back(one);
    }
  }
  std::vector<Traveller> here;
  for (const std::vector<Traveller>& some : ranks.exchange(to))
    here.insert(here.end(), some.begin(), some.end());
  return here;  // each rank's cells arrive in the order of their ids
}

}  // namespace

CellMeasures measureShare(const AnalysisInput& analysis, const std::vector<PlacedCell>& own) {
  const std::vector<Traveller> here = sentToSlices(analysis, own);
  std::vector<PlacedCell> cells;
  std::vector<bool> isOwn, leftOut;
  for (const Traveller& one : here) {
    cells.push_back(one.cell());
    isOwn.push_back(one.own);
    leftOut.push_back(analysis.outside.count(one.id) > 0);
  }
  CertificateInput input;
  input.shapes = analysis.shapes;
  input.container = analysis.container;
  input.cells = &cells;
  input.own = &isOwn;
  input.threads = analysis.threads;
  const CellMeasures found = measureCells(analysis, input, leftOut);

  std::vector<std::vector<Measured>> back(analysis.communicator.size());
  std::size_t n = 0;
  for (const Traveller& one : here) {
    if (!one.own) continue;
    back[one.from].push_back({one.index, found.gap[n], found.localHematocrit[n]});
    ++n;
  }
  CellMeasures measures;
  measures.gap.resize(own.size());
  measures.localHematocrit.resize(own.size());
  for (const std::vector<Measured>& some : analysis.communicator.exchange(back))
    for (const Measured& one : some) {
      measures.gap[one.index] = one.gap;
      measures.localHematocrit[one.index] = one.localHematocrit;
    }
  return measures;
}

}  // namespace packmesh
