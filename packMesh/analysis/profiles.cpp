// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/analysis/profiles.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "packMesh/analysis/cell_measures.h"
#include "packMesh/core/random.h"
#include "packMesh/field/sampled_distance.h"
#include "packMesh/parallel/blocks.h"
#include "packMesh/shape/surface_distance.h"

namespace packmesh {
namespace {

constexpr double nodesOfBox = 1 << 15;
constexpr double nearWall = 3.0;  ///< [spacings]

}  // namespace

WallDepth::WallDepth(const Wall& wall, const Box& box)
    : wall_(wall), box_(box), exact_(wall.closedForm().has_value()) {
  if (exact_) return;
  spacing_ = std::cbrt(box.size().prod() / nodesOfBox);
  std::size_t nodes = 1;
  for (int k = 0; k < 3; ++k) {
    cells_[k] = std::max(1, static_cast<int>(std::ceil(box.size()[k] / spacing_)));
    nodes *= cells_[k] + 1;
  }
  nodes_ = std::vector<std::atomic<double>>(nodes);
  for (std::atomic<double>& node : nodes_) node = std::numeric_limits<double>::quiet_NaN();
}

double WallDepth::node(std::size_t index) const {
  if (const double known = nodes_[index].load(std::memory_order_relaxed); !std::isnan(known)) return known;
  const std::size_t row = cells_[0] + 1, slab = row * (cells_[1] + 1);
  const Vec3 at(double(index % row), double(index % slab / row), double(index / slab));
  const double value = wall_.distance(box_.lo + spacing_ * at).distance;
  nodes_[index].store(value, std::memory_order_relaxed);
  return value;
}

double WallDepth::operator()(const Vec3& p) const {
  if (exact_) return wall_.distance(p).distance;
  const GridCell cell((p - box_.lo) / spacing_, cells_);
  const std::size_t row = cells_[0] + 1, slab = row * (cells_[1] + 1);
  const std::size_t low = cell.node[0] + row * cell.node[1] + slab * cell.node[2];
  const double depth = cell.interpolate(row, slab, [&](std::size_t n) { return node(low + n); }).value;
  return std::abs(depth) > nearWall * spacing_ ? depth : wall_.distance(p).distance;
}

namespace {

/// Sums are formed from integer multiples of these, so that they do not depend on the order.
constexpr double shareStep = 0x1p-26, cosineStep = 0x1p-30;

/// Number of points in all cells, without and with walls whose distance takes microseconds to compute;
/// minimum and maximum per cell.
constexpr std::int64_t pointsOfAll = 1 << 20, pointsAtMeshes = 1 << 18;
constexpr std::int64_t fewestPerCell = 16, mostPerCell = 4096;
constexpr double pointsOfLumen = 1 << 18;

/// The first of these widths [µm] that gives at most mostLayers layers is used.
constexpr std::array<double, 9> widths = {0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 50.0, 200.0, 1000.0};
constexpr double mostLayers = 200.0;

std::int64_t whole(double value, double step) {
  return std::llround(value / step);
}

/// Layers of equal width that cover `length` [µm] from `begin` on.
Profile layersOf(double begin, double length, bool exactly) {
  Profile profile;
  profile.begin = begin;
  for (const double width : widths) {
    profile.width = width;
    if (length <= mostLayers * width) break;
  }
  const double layers = std::max(1.0, std::ceil(length / profile.width - 1e-9));  // tolerates rounding
  if (exactly) profile.width = length / layers;
  profile.lumen.resize(static_cast<std::size_t>(layers), 0.0);
  return profile;
}

class ProfileMeasuring {
 public:
  ProfileMeasuring(const Physics& physics, const Execution& execution, const std::vector<PlacedCell>& cells,
                   const std::array<bool, 3>& ends, const std::set<std::int64_t>& outside, double largestGap)
      : physics_(physics),
        count_(int(physics.species.size())),
        ranks_(execution.communicator),
        container_(*physics.container),
        cells_(cells),
        ends_(ends),
        outside_(outside),
        largestGap_(largestGap),
        bounds_(container_.bounds()),
        period_(container_.period()),
        wall_(container_.wall()) {
    if (wall_) depth_.emplace(*wall_, bounds_);
    const std::int64_t all = ranks_.sum(static_cast<std::int64_t>(cells.size()));
    const std::int64_t points = wall_ && !wall_->closedForm() ? pointsAtMeshes : pointsOfAll;
    measures_.pointsPerCell =
        static_cast<int>(std::clamp(points / std::max<std::int64_t>(1, all), fewestPerCell, mostPerCell));
  }

  PackingMeasures operator()(const std::vector<double>& gaps) {
    for (int k = 0; k < 3; ++k) measures_.axial[k] = layersOf(bounds_.lo[k], bounds_.size()[k], true);
    sampleLumen();
    profileCells();
    for (int s = 0; s < count_; ++s) {
      measures_.gaps.push_back(gapsOf(s, gaps));
      measures_.orientation.push_back(orderOf(s));
    }
    return std::move(measures_);
  }

 private:
  /// Distance to the wall [µm]; empty outside the lumen.
  std::optional<double> toWall(const Vec3& p) const {
    const double distance = (*depth_)(p);
    if (!(distance > 0.0)) return {};
    return distance;
  }
  bool isNearerToEnd(const Vec3& p, double distance) const {
    for (int k = 0; k < 3; ++k)
      if (ends_[k] && period_[k] == 0.0 && std::min(p[k] - bounds_.lo[k], bounds_.hi[k] - p[k]) <= distance)
        return true;
    return false;
  }

  static int layerOf(const Profile& profile, double x) {
    return std::clamp(static_cast<int>(std::floor((x - profile.begin) / profile.width)), 0,
                      profile.layers() - 1);
  }

  /// Volumes of the layers, and the depth of the lumen.
  void sampleLumen() {
    const Vec3 size = bounds_.size();
    if (!wall_) {
      for (int k = 0; k < 3; ++k)
        std::fill(measures_.axial[k].lumen.begin(), measures_.axial[k].lumen.end(),
                  size.prod() / measures_.axial[k].layers());
      return;
    }
    const double edge = std::cbrt(size.prod() / pointsOfLumen);
    std::int64_t n[3];
    for (int k = 0; k < 3; ++k) n[k] = std::max<std::int64_t>(1, std::llround(size[k] / edge));
    measures_.lumenPoints = n[0] * n[1] * n[2];
    std::array<std::vector<std::int64_t>, 3> slices;
    for (int k = 0; k < 3; ++k) slices[k].assign(measures_.axial[k].lumen.size(), 0);
    std::vector<double> depths;
    double deepest = -1.0;
    const Vec3 cube(size[0] / double(n[0]), size[1] / double(n[1]), size[2] / double(n[2]));
    const auto look = [&](const Vec3& p) {
      const auto distance = toWall(p);
      if (!distance) return;
      for (int k = 0; k < 3; ++k) ++slices[k][layerOf(measures_.axial[k], p[k])];
      if (isNearerToEnd(p, *distance)) return;
      depths.push_back(*distance);
      deepest = std::max(deepest, *distance);
    };
    // Block by block, so that blocks outside the lumen are skipped at once.
    constexpr std::int64_t edgeOfBlock = 6;
    std::int64_t blocks[3];
    for (int k = 0; k < 3; ++k) blocks[k] = (n[k] + edgeOfBlock - 1) / edgeOfBlock;
    const std::int64_t all = blocks[0] * blocks[1] * blocks[2];
    const double reach = 0.5 * double(edgeOfBlock) * cube.norm();
    for (std::int64_t b = all * ranks_.rank() / ranks_.size(); b < all * (ranks_.rank() + 1) / ranks_.size();
         ++b) {
      const std::int64_t low[3] = {b % blocks[0] * edgeOfBlock, b / blocks[0] % blocks[1] * edgeOfBlock,
                                   b / (blocks[0] * blocks[1]) * edgeOfBlock};
      Vec3 middle = bounds_.lo;
      for (int k = 0; k < 3; ++k) middle[k] += cube[k] * (double(low[k]) + 0.5 * double(edgeOfBlock));
      if (wall_->distance(middle).distance + reach < -wall_->slack()) continue;
      for (std::int64_t z = low[2]; z < std::min(n[2], low[2] + edgeOfBlock); ++z)
        for (std::int64_t y = low[1]; y < std::min(n[1], low[1] + edgeOfBlock); ++y)
          for (std::int64_t x = low[0]; x < std::min(n[0], low[0] + edgeOfBlock); ++x) {
            const auto u = uniform4(0, RandomStream::sample, std::uint64_t((z * n[1] + y) * n[0] + x), 0);
            look(bounds_.lo + cube.cwiseProduct(Vec3(double(x) + u[0], double(y) + u[1], double(z) + u[2])));
          }
    }
    deepest = ranks_.max(deepest);
    const double each = size.prod() / double(measures_.lumenPoints);
    for (int k = 0; k < 3; ++k) {
      ranks_.sum(slices[k]);
      for (std::size_t i = 0; i < slices[k].size(); ++i)
        measures_.axial[k].lumen[i] = each * double(slices[k][i]);
    }
    if (deepest < 0.0) return;  // all faces are open ends
    measures_.wall = layersOf(0.0, deepest, false);
    std::vector<std::int64_t> counts(measures_.wall->lumen.size(), 0);
    for (const double depth : depths) ++counts[layerOf(*measures_.wall, depth)];
    ranks_.sum(counts);
    for (std::size_t i = 0; i < counts.size(); ++i) measures_.wall->lumen[i] = each * double(counts[i]);
    volumeOfPoint_ = each;
  }

  /// Volumes of cells in layers, in steps, and the number of points.
  struct Sums {
    explicit Sums(const Profile& profile, std::size_t species)
        : layers(profile.lumen.size()), volume(layers * species, 0), points(volume) {}
    void add(int species, int layer, std::int64_t steps) {
      volume[species * layers + layer] += steps;
      ++points[species * layers + layer];
    }
    std::size_t layers;
    std::vector<std::int64_t> volume, points;
  };

  void profileCells() {
    std::vector<std::vector<Vec3>> points(physics_.shapes.size());  // of those that have cells here
    const InnerPoints innerPoints(measures_.pointsPerCell);
    std::vector<Sums> axial;
    for (const Profile& profile : measures_.axial) axial.emplace_back(profile, count_);
    std::optional<Sums> wall;
    if (measures_.wall) wall.emplace(*measures_.wall, count_);
    measures_.leftOut = std::int64_t(outside_.size());
    std::int64_t id = ranks_.sumBefore({std::int64_t(cells_.size())}).front();
    for (const PlacedCell& cell : cells_) {
      if (outside_.count(id++) > 0) continue;
      const Shape& shape = physics_.shapeOf(cell);
      std::vector<Vec3>& inCell = points[cell.shape];
      if (inCell.empty()) inCell = innerPoints(shape);
      const double volume = shape.volume() / double(inCell.size());
      const std::int64_t each = whole(volume, shareStep);
      for (const Vec3& body : inCell) {
        const Vec3 p = wrapped(cell.placement(body), bounds_, period_);
        for (int k = 0; k < 3; ++k) axial[k].add(cell.species, layerOf(measures_.axial[k], p[k]), each);
        if (!wall) continue;
        const double distance = std::max(0.0, toWall(p).value_or(0.0));
        if (!isNearerToEnd(p, distance)) wall->add(cell.species, layerOf(*measures_.wall, distance), each);
      }
    }
    for (int k = 0; k < 3; ++k) finish(measures_.axial[k], axial[k]);
    if (wall) finish(*measures_.wall, *wall);
  }

  void finish(Profile& profile, Sums& sums) const {
    ranks_.sum(sums.volume);
    ranks_.sum(sums.points);
    profile.red.assign(sums.layers, 0.0);
    for (int s = 0; s < count_; ++s) {
      std::vector<double>& fraction = profile.fraction.emplace_back(sums.layers, 0.0);
      std::vector<double>& error = profile.error.emplace_back(sums.layers, 0.0);
      for (std::size_t i = 0; i < sums.layers; ++i) {
        const double volume = shareStep * double(sums.volume[s * sums.layers + i]);
        if (volume == 0.0 || profile.lumen[i] == 0.0) continue;
        fraction[i] = volume / profile.lumen[i];
        const double ofLumen = wall_ ? volumeOfPoint_ / profile.lumen[i] : 0.0;
        error[i] = fraction[i] * std::sqrt(1.0 / double(sums.points[s * sums.layers + i]) + ofLumen);
        if (physics_.species[s].inHematocrit) profile.red[i] += fraction[i];
      }
    }
  }

  GapHistogram gapsOf(int species, const std::vector<double>& gaps) const {
    GapHistogram histogram;
    constexpr double rounding = 1e-9;  // of a whole number of bins
    histogram.counts.assign(static_cast<std::size_t>(std::ceil(largestGap_ / histogram.width - rounding)), 0);
    const auto bins = static_cast<int>(histogram.counts.size());
    constexpr double gapStep = 0x1p-30;
    std::int64_t sum = 0, own = 0;
    double least = largestGap_;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (cells_[i].species != species) continue;
      if (gaps[i] >= largestGap_) {
        ++histogram.beyond;
        continue;
      }
      ++histogram.counts[std::clamp(static_cast<int>(std::floor(gaps[i] / histogram.width)), 0, bins - 1)];
      sum += whole(gaps[i], gapStep);
      ++own;
      least = std::min(least, gaps[i]);
    }
    ranks_.sum(histogram.counts);
    histogram.beyond = ranks_.sum(histogram.beyond);
    const std::int64_t near = ranks_.sum(own);
    sum = ranks_.sum(sum);
    least = ranks_.min(least);
    if (near == 0) return histogram;
    histogram.minimum = least;
    histogram.mean = gapStep * double(sum) / double(near);
    std::int64_t below = 0;
    for (int i = 0; i < bins; ++i) {
      if (2 * (below + histogram.counts[i]) >= near) {
        const double part = (0.5 * double(near) - double(below)) / double(histogram.counts[i]);
        histogram.median = (i + part) * histogram.width;
        break;
      }
      below += histogram.counts[i];
    }
    return histogram;
  }

  OrientationOrder orderOf(int species) const {
    std::vector<std::int64_t> tenths(30, 0), sums(6, 0);  // of xx, yy, zz, xy, xz, yz
    OrientationOrder order;
    for (const PlacedCell& cell : cells_) {
      if (cell.species != species) continue;
      ++order.cells;
      const Vec3 n = cell.placement.linear.col(1).normalized();
      for (int k = 0; k < 3; ++k) ++tenths[10 * k + std::min(9, static_cast<int>(10.0 * std::abs(n[k])))];
      constexpr int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
      for (int k = 0; k < 6; ++k) sums[k] += whole(n[pairs[k][0]] * n[pairs[k][1]], cosineStep);
    }
    ranks_.sum(sums);
    ranks_.sum(tenths);
    for (int k = 0; k < 30; ++k) order.cosines[k / 10][k % 10] = tenths[k];
    order.cells = ranks_.sum(order.cells);
    if (order.cells == 0) return order;
    const auto mean = [&](int k) { return cosineStep * double(sums[k]) / double(order.cells); };
    const Mat3 moments({mean(0), mean(3), mean(4)}, {mean(3), mean(1), mean(5)}, {mean(4), mean(5), mean(2)});
    order.tensor = 1.5 * moments - 0.5 * Mat3::Identity();
    const auto [values, vectors] = principalAxes(order.tensor);
    order.eigenvalues = {values[2], values[1], values[0]};
    order.director = vectors.col(2);
    int largest = 0;
    order.director.cwiseAbs().maxCoeff(&largest);
    if (order.director[largest] < 0.0) order.director = -order.director;
    return order;
  }

  const Physics& physics_;
  const int count_;
  const Communicator& ranks_;
  const Container& container_;
  const std::vector<PlacedCell>& cells_;
  const std::array<bool, 3> ends_;
  const std::set<std::int64_t>& outside_;
  const double largestGap_;  ///< [µm]
  const Box bounds_;
  const Vec3 period_;
  const Wall* const wall_;
  std::optional<WallDepth> depth_;
  double volumeOfPoint_ = 0.0;  ///< of the lumen's samples [µm³]
  PackingMeasures measures_;
};

}  // namespace

std::optional<double> layerBelow(const Profile& profile, double share) {
  double volume = 0.0, red = 0.0;
  for (int i = 0; i < profile.layers(); ++i) {
    volume += profile.lumen[i];
    red += profile.lumen[i] * profile.red[i];
  }
  if (!(red > 0.0)) return {};
  const double wanted = share * red / volume;
  double x = 0.0, before = 0.0;
  for (int i = 0; i < profile.layers(); ++i) {
    const double here = profile.middle(i), reached = profile.red[i];
    if (reached >= wanted) return x + (here - x) * (wanted - before) / (reached - before);
    x = here;
    before = reached;
  }
  return {};
}

PackingMeasures measurePacking(const Physics& physics, const Execution& execution,
                               const std::vector<PlacedCell>& cells, const std::vector<double>& gaps,
                               const std::array<bool, 3>& ends, const std::set<std::int64_t>& outside,
                               double largestGap) {
  return ProfileMeasuring(physics, execution, cells, ends, outside, largestGap)(gaps);
}

}  // namespace packmesh
