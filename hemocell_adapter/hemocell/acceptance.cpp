// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/acceptance.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "hemocell_adapter/hemocell/voxel_distance.h"

namespace packmesh::hemocell {
namespace {

/// int(d/dx) must not lose a node to rounding if d is a multiple of dx.
constexpr double wholeNodes = 1e-9;

int nodesWithin(int minimumDistance, double dx) {
  return minimumDistance > 0 ? static_cast<int>(std::min(minimumDistance / dx + wholeNodes, 1e9)) : 0;
}

/// The node that HemoCell tests for a vertex [µm]; empty if rule 1 already deletes the cell.
std::optional<std::array<int, 3>> nodeOf(const Vec3& p, const Lattice& lattice,
                                         const std::array<bool, 3>& periodic) {
  const std::array<int, 3> nodes = lattice.nodes();
  std::array<int, 3> node;
  for (int k = 0; k < 3; ++k) {
    double u = p[k] / lattice.dx();
    if (periodic[k] && std::isfinite(u)) {
      u -= nodes[k] * std::ceil((u + 0.5) / nodes[k] - 1.0);
      u = std::clamp(u, 0.0, nodes[k] - 0.5);  // within half a node of the first: as the first
    }
    if (!(u > -0.5 && u <= nodes[k] - 0.5)) return {};
    // Rounds as HemoCell does. NOLINTNEXTLINE(bugprone-incorrect-roundings): not negative here
    node[k] = std::min(static_cast<int>(u + 0.5), nodes[k] - 1);
  }
  return node;
}

/// Contacts are only searched for up to the clearance plus this distance from the wall [µm].
constexpr double noContact = 0.3;

/// Distances at the nodes of a block from those at every other node: their means, which need no Trilinear.
void refine(const std::vector<float>& coarse, const NodeBlock& block, float* distances) {
  const int row = (block.nodes[0] + 1) / 2, slab = row * ((block.nodes[1] + 1) / 2);
  for (int k = 0; k < block.nodes[2]; ++k)
    for (int j = 0; j < block.nodes[1]; ++j) {
      const float* low = &coarse[j / 2 * row + k / 2 * slab];
      const int dy = j % 2 * row, dz = k % 2 * slab;
      const auto across = [&](int i) {
        return 0.25f * ((low[i] + low[i + dy]) + (low[i + dz] + low[i + dy + dz]));
      };
      float before = across(0);
      *distances++ = before;
      for (int i = 1; i < block.nodes[0]; i += 2) {
        const float after = across((i + 1) / 2);
        *distances++ = 0.5f * (before + after);
        if (i + 1 < block.nodes[0]) *distances++ = after;
        before = after;
      }
    }
}

class AcceptedWall final : public Wall {
 public:
  AcceptedWall(const Wall* wall, std::shared_ptr<const Lattice> lattice, int minimumDistanceFromSolid,
               double wallClearance)
      : wall_(wall),
        acceptance_(std::move(lattice), minimumDistanceFromSolid),
        voxels_(acceptance_.allowedNodes()),
        wallClearance_(wallClearance),
        kept_(acceptance_.allowedNodes().keptRegion()),
        // The corner of a cube around a node outside, including the cube of nodes that it forbids.
        reach_((nodesWithin(minimumDistanceFromSolid, dx()) + 0.5) * std::sqrt(3.0) * dx() +
               (wall ? wall->slack() : 0.0)) {
    const double known = VoxelDistance::fineReach * dx() - reach_;
    deep_ = known > 0.0 ? known : std::numeric_limits<double>::infinity();
  }

  WallDistance distance(const Vec3& p) const override {
    if (!wall_) return voxels(p);
    const WallDistance wall = wall_->distance(p);
    double distance = wall.distance;
    if (!isOpen(distance, std::min({toFace(p, 0), toFace(p, 1), toFace(p, 2)})))
      return {distance, wall.gradient};
    const WallDistance voxel = voxels(p);
    return wall.distance < voxel.distance ? wall : voxel;
  }

  void sample(const NodeBlock& block, float* distances) const override {
    if (wall_) sampleWall(block, distances);
    const std::optional<VoxelDistance::SampleRows> rows = voxels_.rowsOf(block);
    const int n = block.nodes[0];
    std::vector<float> toFaces(n), voxel(n, std::numeric_limits<float>::quiet_NaN());
    std::vector<char> open(n, true);  // not determined by the true wall
    for (int i = 0; i < n; ++i) toFaces[i] = static_cast<float>(toFace(block.position(i, 0, 0), 0));
    for (int k = 0; k < block.nodes[2]; ++k)
      for (int j = 0; j < block.nodes[1]; ++j, distances += n) {
        if (wall_) {
          const Vec3 first = block.position(0, j, k);
          const float across = static_cast<float>(std::min(toFace(first, 1), toFace(first, 2)));
          bool any = false;
          for (int i = 0; i < n; ++i) any |= open[i] = isOpen(distances[i], std::min(toFaces[i], across));
          if (!any) continue;
        } else {
          std::fill(distances, distances + n, std::numeric_limits<float>::infinity());
        }
        if (rows)
          voxels_.atSamples(
              {rows->first[0], rows->first[1] + rows->step * j, rows->first[2] + rows->step * k}, rows->step,
              n, voxel.data());
        for (int i = 0; i < n; ++i) {
          if (!open[i]) continue;
          const float distance = std::isnan(voxel[i])
                                     ? static_cast<float>(voxels(block.position(i, j, k)).distance)
                                     : voxel[i] + static_cast<float>(wallClearance_);
          distances[i] = std::min(distances[i], distance);
        }
      }
  }

  /// If the true wall consists of cubes, too: nodes where vertices are kept are inside it.
  WallDistance smoothed(const Vec3& p) const override { return voxels_.smoothed(p); }
  double smoothReach() const override {
    return wall_ && wall_->smoothReach() > 0.0 ? voxels_.smoothReach() : 0.0;
  }

  double slack() const override { return std::max(voxels_.slack(), wall_ ? wall_->slack() : 0.0); }

  /// Faces and centres of voxels are at multiples of this.
  double samplingSpacing() const override { return 0.5 * dx(); }

  bool isAway(const Sphere& sphere, double gap) const override {
    return voxels_.at(sphere.center).distance - voxels_.slack() > sphere.radius &&
           (!wall_ || wall_->isAway(sphere, gap));
  }

  WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest) const override {
    WallVerdict verdict;
    if (wall_) verdict = wall_->examine(cell, gapOfInterest);
    if (verdict.violation) return verdict;
    verdict.violation = acceptance_.violation(placedVertices(cell.hierarchy.mesh(), cell.placement));
    return verdict;
  }

 private:
  /// Distances to the true wall; only at every second node if its samples are no finer than that.
  void sampleWall(const NodeBlock& block, float* distances) const {
    NodeBlock coarse = block;
    coarse.spacing *= 2.0;
    bool odd = true;
    std::size_t count = 1;
    for (int k = 0; k < 3; ++k) {
      odd = odd && block.nodes[k] % 2 == 1;
      coarse.nodes[k] = (block.nodes[k] + 1) / 2;
      count *= coarse.nodes[k];
    }
    if (!odd || wall_->closedForm() || wall_->samplingSpacing() < coarse.spacing) {
      wall_->sample(block, distances);
      return;
    }
    std::vector<float> values(count);
    wall_->sample(coarse, values.data());
    refine(values, block, distances);
  }

  /// Distance along an axis to the nearer face of the kept region [µm].
  double toFace(const Vec3& p, int axis) const {
    return std::min(p[axis] - kept_.lo[axis], kept_.hi[axis] - p[axis]);
  }

  /// True if the voxels are needed, given the distance to the true wall. Otherwise sets `distance`: further
  /// inside than any contact, to a bound of the distance to the forbidden voxels; far outside, to the
  /// distance to the true wall.
  /// @param toFaces distance to the faces of the kept region [µm]
  template <class Real>
  bool isOpen(Real& distance, Real toFaces) const {
    const Real beyond = std::min(distance - static_cast<Real>(reach_), toFaces);
    if (beyond > static_cast<Real>(noContact)) {
      distance = std::min(distance, beyond + static_cast<Real>(wallClearance_));
      return false;
    }
    if (distance < static_cast<Real>(-deep_)) {
      distance -= static_cast<Real>(0.5 * reach_);
      return false;
    }
    return true;
  }

  WallDistance voxels(const Vec3& p) const {
    WallDistance voxels = voxels_.at(p);
    voxels.distance += wallClearance_;
    return voxels;
  }
  double dx() const { return acceptance_.allowedNodes().dx(); }

  const Wall* wall_;
  Acceptance acceptance_;
  VoxelDistance voxels_;
  double wallClearance_;
  Box kept_;
  double reach_;  ///< largest distance of forbidden voxels from the true wall or the kept faces [µm]
  double deep_;   ///< depth outside beyond which the voxels are not used [µm]
};

}  // namespace

Acceptance::Acceptance(std::shared_ptr<const Lattice> lattice, int minimumDistanceFromSolid)
    : lattice_(std::move(lattice)), allowed_(lattice_), minimumDistance_(minimumDistanceFromSolid) {
  if (const int radius = nodesWithin(minimumDistanceFromSolid, lattice_->dx()); radius > 0)
    allowed_ = std::make_shared<const Lattice>(lattice_->eroded(radius));
}

std::optional<std::string> Acceptance::violation(const std::vector<Vec3>& vertices,
                                                 const AcceptanceExceptions& except) const {
  const Lattice& allowed = except.anyDistance ? *lattice_ : *allowed_;
  for (const Vec3& p : vertices) {
    const auto node = nodeOf(p, allowed, except.periodic);
    if (!node) return "a vertex lies outside the lattice";
    const auto [i, j, k] = *node;
    if (allowed.fluid(i, j, k)) continue;
    if (!lattice_->fluid(i, j, k)) return "a vertex lies on a wall node";
    return fmt::format("closer than {} µm to a solid node", minimumDistance_);
  }
  return {};
}

std::unique_ptr<Wall> makeAcceptedWall(const Wall* wall, std::shared_ptr<const Lattice> lattice,
                                       int minimumDistanceFromSolid, double wallClearance) {
  return std::make_unique<AcceptedWall>(wall, std::move(lattice), minimumDistanceFromSolid, wallClearance);
}

namespace {

/// Another wall, translated.
class MovedWall : public Wall {
 public:
  MovedWall(const Wall* wall, const Vec3& shift) : wall_(wall), shift_(shift) {}

  WallDistance distance(const Vec3& p) const override { return wall_->distance(p - shift_); }
  WallDistance smoothed(const Vec3& p) const override { return wall_->smoothed(p - shift_); }
  double smoothReach() const override { return wall_->smoothReach(); }
  double slack() const override { return wall_->slack(); }
  double samplingSpacing() const override { return wall_->samplingSpacing(); }
  void sample(const NodeBlock& block, float* distances) const override {
    NodeBlock moved = block;
    moved.origin -= shift_;
    wall_->sample(moved, distances);
  }
  bool isAway(const Sphere& sphere, double gap) const override {
    return wall_->isAway({sphere.center - shift_, sphere.radius}, gap);
  }
  WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest) const override {
    const Placement moved{cell.placement.linear, cell.placement.translation - shift_};
    return wall_->examine({cell.hierarchy, moved}, gapOfInterest);
  }

 private:
  const Wall* wall_;
  Vec3 shift_;
};

/// The container's wall in the coordinate system of the repeated lattice, the accepted wall made from it, and
/// that one moved back to the coordinate system of .pos files.
struct OwnedWalls {
  std::shared_ptr<const Container> container;
  std::unique_ptr<const Wall> inFrame, accepted, result;
};

}  // namespace

std::shared_ptr<const Wall> makePeriodicAcceptedWall(std::shared_ptr<const Container> container,
                                                     std::shared_ptr<const Lattice> lattice,
                                                     int minimumDistanceFromSolid, double reach,
                                                     double wallClearance) {
  auto walls = std::make_shared<OwnedWalls>();
  walls->container = std::move(container);
  const Wall* wall = walls->container->wall();
  const Vec3 period = walls->container->period();
  if (period.isZero()) {
    walls->result = makeAcceptedWall(wall, std::move(lattice), minimumDistanceFromSolid, wallClearance);
    return {walls, walls->result.get()};
  }
  // Repeat enough nodes on both sides that no vertex meets the faces of the lattice.
  const double dx = lattice->dx();
  std::array<int, 3> margin{};
  for (int k = 0; k < 3; ++k) {
    if (period[k] > 0)
      margin[k] = int(std::ceil((reach + minimumDistanceFromSolid + 2 * wallClearance) / dx)) + 2;
  }
  auto repeated = std::make_shared<Lattice>(lattice->repeated(margin));
  const Vec3 shift = dx * Vec3(margin[0], margin[1], margin[2]);
  if (wall) walls->inFrame = std::make_unique<MovedWall>(wall, shift);
  walls->accepted =
      makeAcceptedWall(walls->inFrame.get(), std::move(repeated), minimumDistanceFromSolid, wallClearance);
  walls->result = std::make_unique<MovedWall>(walls->accepted.get(), -shift);
  return {walls, walls->result.get()};
}

}  // namespace packmesh::hemocell
