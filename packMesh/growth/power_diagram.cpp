// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/power_diagram.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "packMesh/certificate/periodic_neighbors.h"
#include "packMesh/parallel/periodic_images.h"

namespace packmesh {
namespace {

constexpr double pi = 3.14159265358979323846;

/// Points of the lumen for each cell: their mean errs by about a twentieth of the cell's radius.
constexpr std::size_t pointsPerCell = 100;

/// Points tried for each point in the lumen, at most.
constexpr std::size_t triesPerPoint = 100;

/// Points further from a centre than this many times the radius of its share are seldom the centre's.
constexpr double usualReach = 2.0;

/// Points of the lumen, sorted into buckets.
class LumenPoints {
 public:
  LumenPoints(const Box& bounds, const Vec3& period, const Wall* wall, std::size_t count, double bucketEdge)
      : bounds_(bounds), period_(period) {
    std::size_t buckets = 1;
    for (int k = 0; k < 3; ++k) {
      buckets_[k] = std::max(1, static_cast<int>(std::min(bounds.size()[k] / bucketEdge, 200.0)));
      buckets *= buckets_[k];
    }
    members_.resize(buckets);
    // The R3 sequence (M. Roberts 2018): multiples of the powers of 1/g, with g⁴ = g + 1.
    constexpr double g = 1.2207440846057594754;
    const Vec3 step(1.0 / g, 1.0 / (g * g), 1.0 / (g * g * g));
    for (std::size_t i = 0; points_.size() < count && i < triesPerPoint * count; ++i) {
      Vec3 p;
      for (int k = 0; k < 3; ++k) {
        const double u = 0.5 + static_cast<double>(i) * step[k];
        p[k] = bounds.lo[k] + (u - std::floor(u)) * bounds.size()[k];
      }
      if (wall && !(wall->distance(p).distance > 0.0)) continue;
      members_[bucketOf(p)].push_back(static_cast<int>(points_.size()));
      points_.push_back(p);
    }
  }

  std::size_t count() const { return points_.size(); }
  const Vec3& point(std::size_t i) const { return points_[i]; }

  /// From `center` to the nearest image of `p`.
  Vec3 offset(const Vec3& center, const Vec3& p) const {
    Vec3 d = p - center;
    for (int k = 0; k < 3; ++k)
      if (period_[k] > 0.0) d[k] -= period_[k] * std::round(d[k] / period_[k]);
    return d;
  }

  /// Calls visit(i) for all points within `reach` of `center`, and some others.
  template <class Visit>
  void forEachAround(const Vec3& center, double reach, Visit&& visit) const {
    int lo[3], count[3];
    for (int k = 0; k < 3; ++k) {
      const double perLength = buckets_[k] / bounds_.size()[k];
      lo[k] = static_cast<int>(std::floor((center[k] - reach - bounds_.lo[k]) * perLength));
      int hi = static_cast<int>(std::floor((center[k] + reach - bounds_.lo[k]) * perLength));
      if (!(period_[k] > 0.0)) {
        lo[k] = std::clamp(lo[k], 0, buckets_[k] - 1);
        hi = std::clamp(hi, 0, buckets_[k] - 1);
      }
      count[k] = std::min(hi - lo[k] + 1, buckets_[k]);
    }
    for (int z = 0; z < count[2]; ++z)
      for (int y = 0; y < count[1]; ++y)
        for (int x = 0; x < count[0]; ++x) {
          const int at[3] = {lo[0] + x, lo[1] + y, lo[2] + z};
          std::size_t bucket = 0;
          for (int k = 2; k >= 0; --k)
            bucket = bucket * buckets_[k] + (at[k] % buckets_[k] + buckets_[k]) % buckets_[k];
          for (const int i : members_[bucket]) visit(i);
        }
  }

 private:
  std::size_t bucketOf(const Vec3& p) const {
    std::size_t bucket = 0;
    for (int k = 2; k >= 0; --k) {
      const int i = static_cast<int>((p[k] - bounds_.lo[k]) / bounds_.size()[k] * buckets_[k]);
      bucket = bucket * buckets_[k] + std::clamp(i, 0, buckets_[k] - 1);
    }
    return bucket;
  }

  Box bounds_;
  Vec3 period_;
  int buckets_[3];
  std::vector<Vec3> points_;
  std::vector<std::vector<int>> members_;
};

/// One round of Lloyd's algorithm.
std::vector<Vec3> centroids(const LumenPoints& points, const std::vector<Vec3>& centers,
                            const std::vector<double>& radii) {
  std::vector<double> least(points.count(), std::numeric_limits<double>::infinity());
  std::vector<int> owner(points.count(), -1);
  const auto claim = [&](std::size_t c, std::size_t i) {
    const double power = points.offset(centers[c], points.point(i)).squaredNorm() - radii[c] * radii[c];
    if (power < least[i]) {
      least[i] = power;
      owner[i] = static_cast<int>(c);
    }
  };
  for (std::size_t c = 0; c < centers.size(); ++c)
    points.forEachAround(centers[c], usualReach * radii[c], [&](int i) { claim(c, i); });
  std::vector<Vec3> sum(centers.size(), Vec3::Zero());
  std::vector<int> number(centers.size(), 0);
  for (std::size_t i = 0; i < points.count(); ++i) {
    if (owner[i] < 0)
      for (std::size_t c = 0; c < centers.size(); ++c) claim(c, i);
    sum[owner[i]] += points.offset(centers[owner[i]], points.point(i));
    ++number[owner[i]];
  }
  std::vector<Vec3> out = centers;
  for (std::size_t c = 0; c < centers.size(); ++c) {
    if (number[c] > 0) {
      out[c] += sum[c] / number[c];
      continue;
    }
    // Hidden by larger ones: it would stay beside them for ever. It moves to the middle of the largest gap.
    const auto farthest = std::max_element(least.begin(), least.end()) - least.begin();
    out[c] = points.point(static_cast<std::size_t>(farthest));
    points.forEachAround(out[c], usualReach * radii[c], [&](int i) {
      least[i] =
          std::min(least[i], points.offset(out[c], points.point(i)).squaredNorm() - radii[c] * radii[c]);
    });
  }
  return out;
}

bool spheresMeet(const GrowthScene& scene, const std::vector<Sphere>& spheres) {
  const PeriodicNeighbors neighbors(spheres, scene.container->period());
  bool meet = false;
  for (std::size_t i = 0; i < spheres.size() && !meet; ++i)
    neighbors.forEachNear(static_cast<std::int64_t>(i), scene.clearance, true,
                          [&](const NearPair&) { meet = true; });
  return meet;
}

}  // namespace

void spreadByPowerDiagram(const GrowthScene& scene, int rounds, GrowthState& state) {
  if (state.empty()) return;
  double volume = 0.0;
  for (const GrowingCell& cell : state) volume += scene.shapes[cell.species]->volume();
  std::vector<double> radii;
  std::vector<Vec3> centers;
  double mean = 0.0;
  for (const GrowingCell& cell : state) {
    const double share = scene.container->volume() * scene.shapes[cell.species]->volume() / volume;
    radii.push_back(std::cbrt(0.75 / pi * share));
    mean += radii.back() / static_cast<double>(state.size());
    centers.push_back(cell.pose.position);
  }
  const Box bounds = scene.container->bounds();
  const Vec3 period = scene.container->period();
  const LumenPoints points(bounds, period, scene.container->wall(), pointsPerCell * state.size(), mean);
  for (int round = 0; round < rounds; ++round) {
    const std::vector<Vec3> moved = centroids(points, centers, radii);
    for (std::size_t i = 0; i < state.size(); ++i) {
      const Vec3 p = wrapped(moved[i], bounds, period);
      const Wall* wall = scene.walls[state[i].species];
      const double radius = state[i].pose.scale * scene.shapes[state[i].species]->radius();
      if (!wall || wall->distance(p).distance - wall->slack() > radius + scene.wallClearance) centers[i] = p;
    }
  }
  std::vector<Sphere> spheres;
  for (std::size_t i = 0; i < state.size(); ++i)
    spheres.push_back({centers[i], state[i].pose.scale * scene.shapes[state[i].species]->radius()});
  if (spheresMeet(scene, spheres)) return;
  for (std::size_t i = 0; i < state.size(); ++i) state[i].pose.position = centers[i];
}

}  // namespace packmesh
