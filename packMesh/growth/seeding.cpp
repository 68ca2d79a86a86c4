// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/seeding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "packMesh/core/error.h"
#include "packMesh/core/random.h"
#include "packMesh/core/vector_text.h"
#include "packMesh/growth/power_diagram.h"
#include "packMesh/parallel/periodic_images.h"

namespace packmesh {
namespace {

/// Tries for one cell.
constexpr std::uint32_t tries = 20000;

/// Volumes that differ by less than this fraction are the same.
constexpr double sameVolume = 0.01;

/// Spheres put into the lumen one after the other; none may come nearer than the clearance to another one or
/// an image of it.
class SphereRoom {
 public:
  /// @param reach largest distance of two centres that can be too near [µm]
  SphereRoom(const Box& bounds, const Vec3& period, double reach) : bounds_(bounds), period_(period) {
    std::size_t count = 1;
    for (int k = 0; k < 3; ++k) {
      cells_[k] = std::max(1, static_cast<int>(std::min(bounds.size()[k] / reach, 200.0)));
      count *= cells_[k];
    }
    members_.resize(count);
  }

  bool fits(const Vec3& center, double radius, double clearance) const {
    for (int k = 0; k < 3; ++k)
      if (period_[k] > 0.0 && 2.0 * radius + clearance >= period_[k]) return false;
    bool free = true;
    forEachBlockAround(center, [&](std::size_t block) {
      for (const Sphere& other : members_[block]) {
        Vec3 apart = center - other.center;
        for (int k = 0; k < 3; ++k)
          if (period_[k] > 0.0) apart[k] -= period_[k] * std::round(apart[k] / period_[k]);
        free = free && apart.norm() > radius + other.radius + clearance;
      }
    });
    return free;
  }

  void add(const Vec3& center, double radius) { members_[blockOf(center)].push_back({center, radius}); }

 private:
  int indexOf(int axis, double x) const {
    const double i = std::floor((x - bounds_.lo[axis]) / bounds_.size()[axis] * cells_[axis]);
    return i <= 0.0 ? 0 : i >= cells_[axis] - 1 ? cells_[axis] - 1 : static_cast<int>(i);
  }
  std::size_t blockOf(const Vec3& p) const {
    return indexOf(0, p[0]) +
           std::size_t(cells_[0]) * (indexOf(1, p[1]) + std::size_t(cells_[1]) * indexOf(2, p[2]));
  }
  template <class Visit>
  void forEachBlockAround(const Vec3& p, Visit&& visit) const {
    int lo[3], hi[3];
    for (int k = 0; k < 3; ++k) {
      const int i = indexOf(k, p[k]);
      lo[k] = cells_[k] < 3 ? 0 : i - 1;
      hi[k] = cells_[k] < 3 ? cells_[k] - 1 : i + 1;
      if (!(period_[k] > 0.0)) {
        lo[k] = std::max(lo[k], 0);
        hi[k] = std::min(hi[k], cells_[k] - 1);
      }
    }
    for (int z = lo[2]; z <= hi[2]; ++z)
      for (int y = lo[1]; y <= hi[1]; ++y)
        for (int x = lo[0]; x <= hi[0]; ++x) {
          const int i[3] = {x, y, z};
          std::size_t block = 0;
          for (int k = 2; k >= 0; --k) block = block * cells_[k] + (i[k] + cells_[k]) % cells_[k];
          visit(block);
        }
  }

  Box bounds_;
  Vec3 period_;
  int cells_[3];
  std::vector<std::vector<Sphere>> members_;
};

}  // namespace

GrowthState seedRandomly(const GrowthScene& scene, const std::vector<std::int64_t>& counts,
                         const std::vector<std::string>& names, double scale) {
  const Box bounds = scene.container->bounds();
  GrowthState state;
  std::vector<int> numberInSpecies;
  double largest = 0.0;
  for (std::size_t s = 0; s < counts.size(); ++s)
    for (std::int64_t i = 0; i < counts[s]; ++i) {
      state.push_back({static_cast<int>(s), Pose{scale, Quaternion::Identity(), Vec3::Zero()}});
      numberInSpecies.push_back(static_cast<int>(i));
      largest = std::max(largest, scale * scene.shapes[s]->radius());
    }
  std::vector<std::size_t> order(state.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return scene.shapes[state[a].species]->radius() > scene.shapes[state[b].species]->radius();
  });
  SphereRoom room(bounds, scene.container->period(), 2.0 * largest + scene.clearance);
  for (const std::size_t i : order) {
    GrowingCell& cell = state[i];
    const double radius = scale * scene.shapes[cell.species]->radius();
    const Wall* wall = scene.walls[cell.species];
    bool placed = false;
    for (std::uint32_t attempt = 0; attempt < tries && !placed; ++attempt) {
      const auto u = uniform4(scene.seed, RandomStream::position, i, attempt);
      const Vec3 p = bounds.lo + bounds.size().cwiseProduct(Vec3(u[0], u[1], u[2]));
      if (wall && wall->distance(p).distance - wall->slack() <= radius + scene.wallClearance) continue;
      if (!room.fits(p, radius, scene.clearance)) continue;
      cell.pose.position = wrapped(p, bounds, scene.container->period());
      placed = true;
    }
    if (!placed)
      throw InputError("no room for cell " + std::to_string(numberInSpecies[i] + 1) + " of species '" +
                       names[cell.species] + "', even shrunk to " + toText(scale) + " of its size");
    room.add(cell.pose.position, radius);
    if (!scene.rotate) continue;
    const auto u = uniform4(scene.seed, RandomStream::orientation, i, 0);
    cell.pose.orientation = uniformRotation(u[0], u[1], u[2]);
  }
  return state;
}

GrowthState seed(const GrowthScene& scene, const std::vector<std::int64_t>& counts,
                 const std::vector<std::string>& names, const GrowthSettings& settings) {
  GrowthState state = seedRandomly(scene, counts, names, settings.initialScale);
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (std::size_t s = 0; s < counts.size(); ++s) {
    if (counts[s] == 0) continue;
    least = std::min(least, scene.shapes[s]->volume());
    most = std::max(most, scene.shapes[s]->volume());
  }
  if (most > (1.0 + sameVolume) * least) spreadByPowerDiagram(scene, settings.spreadRounds, state);
  return state;
}

}  // namespace packmesh
