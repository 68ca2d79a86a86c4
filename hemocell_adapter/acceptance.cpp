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

class AcceptedWall final : public Wall {
 public:
  AcceptedWall(const Wall* wall, std::shared_ptr<const Lattice> lattice, int minimumDistanceFromSolid,
               double wallClearance)
      : wall_(wall),
        acceptance_(std::move(lattice), minimumDistanceFromSolid),
        voxels_(acceptance_.allowedNodes()),
        wallClearance_(wallClearance),
        kept_(acceptance_.allowedNodes().keptRegion()),
        reach_((nodesWithin(minimumDistanceFromSolid, dx()) + 2) * std::sqrt(3.0) * dx()) {}

  WallDistance distance(const Vec3& p) const override {
    if (wall_) {
      // Far inside, a bound of the distance to the forbidden voxels will do: they begin within `reach_` of the
      // true wall and of the kept region's faces.
      const WallDistance wall = wall_->distance(p);
      const double toFaces = std::min((p - kept_.lo).minCoeff(), (kept_.hi - p).minCoeff());
      if (std::min(wall.distance, toFaces) > wallClearance_ + 2.0 * reach_)
        return {std::min(wall.distance, std::min(wall.distance, toFaces) - reach_ + wallClearance_), wall.gradient};
    }
    WallDistance voxels = voxels_.at(p);
    voxels.distance += wallClearance_;
    if (!wall_) return voxels;
    const WallDistance wall = wall_->distance(p);
    return wall.distance < voxels.distance ? wall : voxels;
  }

  double slack() const override { return std::max(voxels_.slack(), wall_ ? wall_->slack() : 0.0); }

  std::optional<std::string> objection(const TriangleMesh& placedCell) const override {
    if (wall_)
      if (std::optional<std::string> objection = wall_->objection(placedCell)) return objection;
    return acceptance_.objection(placedCell.vertices);
  }

 private:
  double dx() const { return acceptance_.allowedNodes().dx(); }

  const Wall* wall_;
  Acceptance acceptance_;
  VoxelDistance voxels_;
  double wallClearance_;
  Box kept_;
  double reach_;  ///< [µm]
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
