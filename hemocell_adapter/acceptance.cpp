// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/acceptance.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "hemocell_adapter/voxel_distance.h"

namespace packmesh::hemocell {
namespace {

/// int(d/dx) must not lose a node to rounding when dx divides d.
constexpr double wholeNodes = 1e-9;

int nodesWithin(int minimumDistance, double dx) {
  return minimumDistance > 0 ? static_cast<int>(std::min(minimumDistance / dx + wholeNodes, 1e9)) : 0;
}

/// The node HemoCell looks at for a vertex [µm]; nothing when rule 1 already deletes the cell.
std::optional<std::array<int, 3>> nodeOf(const Vec3& p, const Lattice& lattice) {
  const std::array<int, 3> nodes = lattice.nodes();
  std::array<int, 3> node;
  for (int k = 0; k < 3; ++k) {
    const double u = p[k] / lattice.dx();
    if (!(u > -0.5 && u <= nodes[k] - 0.5)) return {};
    node[k] = std::min(static_cast<int>(u + 0.5), nodes[k] - 1);
  }
  return node;
}

/// Beyond the clearance, no contact is looked for further from the wall than this [µm].
constexpr double noContact = 0.5;

class AcceptedWall final : public Wall {
 public:
  AcceptedWall(const Wall* wall, std::shared_ptr<const Lattice> lattice, int minimumDistanceFromSolid,
               double wallClearance)
      : wall_(wall),
        acceptance_(std::move(lattice), minimumDistanceFromSolid),
        voxels_(acceptance_.allowedNodes()),
        wallClearance_(wallClearance),
        kept_(acceptance_.allowedNodes().keptRegion()),
        // The corner of a cube around a node outside, with the cube of nodes it forbids.
        reach_((nodesWithin(minimumDistanceFromSolid, dx()) + 0.5) * std::sqrt(3.0) * dx() +
               (wall ? wall->slack() : 0.0)) {}

  WallDistance distance(const Vec3& p) const override {
    if (!wall_) return voxels(p);
    const WallDistance wall = wall_->distance(p);
    // Further in than any contact, a bound of the distance to the forbidden voxels will do.
    const double toFaces = std::min((p - kept_.lo).minCoeff(), (kept_.hi - p).minCoeff());
    const double bound = wallClearance_ + std::min(wall.distance - reach_, toFaces);
    if (bound > wallClearance_ + noContact) return {std::min(wall.distance, bound), wall.gradient};
    const WallDistance voxel = voxels(p);
    return wall.distance < voxel.distance ? wall : voxel;
  }

  double slack() const override { return std::max(voxels_.slack(), wall_ ? wall_->slack() : 0.0); }

  /// Faces and middles of the voxels are at multiples of this.
  double samplingSpacing() const override { return 0.5 * dx(); }

  std::optional<std::string> objection(const TriangleMesh& placedCell) const override {
    if (wall_)
      if (std::optional<std::string> objection = wall_->objection(placedCell)) return objection;
    return acceptance_.objection(placedCell.vertices);
  }

 private:
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
  double reach_;  ///< forbidden voxels are no further from the true wall or the kept faces than this [µm]
};

}  // namespace

Acceptance::Acceptance(std::shared_ptr<const Lattice> lattice, int minimumDistanceFromSolid)
    : lattice_(std::move(lattice)),
      allowed_(lattice_->eroded(nodesWithin(minimumDistanceFromSolid, lattice_->dx()))),
      minimumDistance_(minimumDistanceFromSolid) {}

bool Acceptance::allows(const Vec3& p) const {
  const auto node = nodeOf(p, allowed_);
  return node && allowed_.fluid((*node)[0], (*node)[1], (*node)[2]);
}

std::optional<std::string> Acceptance::objection(const std::vector<Vec3>& vertices) const {
  for (const Vec3& p : vertices) {
    const auto node = nodeOf(p, allowed_);
    if (!node) return "a vertex lies outside the lattice";
    const auto [i, j, k] = *node;
    if (allowed_.fluid(i, j, k)) continue;
    if (!lattice_->fluid(i, j, k)) return "a vertex lies on a wall node";
    return fmt::format("nearer than {} µm to a solid node", minimumDistance_);
  }
  return {};
}

std::unique_ptr<Wall> makeAcceptedWall(const Wall* wall, std::shared_ptr<const Lattice> lattice,
                                       int minimumDistanceFromSolid, double wallClearance) {
  return std::make_unique<AcceptedWall>(wall, std::move(lattice), minimumDistanceFromSolid, wallClearance);
}

}  // namespace packmesh::hemocell
