// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/periodic_wall.h"

#include <cmath>
#include <utility>

namespace packmesh::hemocell {
namespace {

/// Another wall, translated.
class MovedWall : public Wall {
 public:
  MovedWall(const Wall* wall, const Vec3& shift) : wall_(wall), shift_(shift) {}

  WallDistance distance(const Vec3& p) const override { return wall_->distance(p - shift_); }
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
