// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/voxel_lumen.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "hemocell_adapter/hemocell/voxel_distance.h"
#include "packMesh/container/surface_wall.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

/// Distances beyond the ends of a periodic lumen take its images into account up to this far from the ends
/// [µm]: more than the radius of any blood cell, and than the blocks in which distances are sampled.
constexpr double imageReach = 16.0;

class VoxelLumen final : public Container, public Wall {
 public:
  VoxelLumen(std::shared_ptr<const Lattice> lattice, int margin)
      : lattice_(std::move(lattice)),
        margin_(margin),
        repeated_(margin > 0 ? std::make_unique<const Lattice>(lattice_->repeated({margin, 0, 0})) : nullptr),
        voxels_(repeated_ ? *repeated_ : *lattice_),
        surface_(voxelSurface(*lattice_, margin > 0)),
        bounds_(boundingBox(surface_)),
        wall_(surface_, 0, lattice_->keptRegion().lo.x(), periodic() ? length() : 0.0) {
    if (!periodic()) return;
    bounds_.lo.x() = lattice_->keptRegion().lo.x();
    bounds_.hi.x() = lattice_->keptRegion().hi.x();
  }

  Box bounds() const override { return bounds_; }
  Vec3 period() const override { return {periodic() ? length() : 0.0, 0.0, 0.0}; }
  double volume() const override { return lattice_->fluidVolume(); }
  const Wall* wall() const override { return this; }
  TriangleMesh surface() const override { return surface_; }

  std::string describe() const override {
    const Vec3 size = bounds_.size();
    return fmt::format("{} fluid nodes in {:.6g} x {:.6g} x {:.6g} µm, {} along x", lattice_->fluidNodes(),
                       size.x(), size.y(), size.z(), periodic() ? "periodic" : "closed");
  }

  WallDistance distance(const Vec3& p) const override { return voxels_.at(inFrame(p)); }
  double slack() const override { return voxels_.slack(); }
  double samplingSpacing() const override { return 0.5 * lattice_->dx(); }

  void sample(const NodeBlock& block, float* distances) const override {
    NodeBlock moved = block;
    const Vec3 middle = block.position(block.nodes[0] / 2, block.nodes[1] / 2, block.nodes[2] / 2);
    moved.origin += inFrame(middle) - middle;
    voxels_.sample(moved, distances);
  }

  WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest) const override {
    return wall_.examine(cell, gapOfInterest, gapOfInterest, [&](const Vec3& p) { return contains(p); });
  }

 private:
  bool periodic() const { return margin_ > 0; }
  double length() const { return lattice_->nodes()[0] * lattice_->dx(); }

  /// Position of p in the repeated lattice: in its central period, if the lumen repeats.
  Vec3 inFrame(const Vec3& p) const {
    if (!periodic()) return p;
    const int shift = margin_ - wall_.imageOf(p.x()) * lattice_->nodes()[0];
    return p + Vec3(shift * lattice_->dx(), 0.0, 0.0);
  }

  /// Pre: p is not on the surface.
  bool contains(const Vec3& p) const { return voxels_.at(inFrame(p)).distance > 0.0; }

  std::shared_ptr<const Lattice> lattice_;
  int margin_;  ///< nodes repeated at either end; 0: not periodic
  std::unique_ptr<const Lattice> repeated_;
  VoxelDistance voxels_;
  TriangleMesh surface_;
  Box bounds_;
  SurfaceWall wall_;
};

}  // namespace

std::unique_ptr<Container> makeVoxelLumen(std::shared_ptr<const Lattice> lattice, bool periodic) {
  if (lattice->fluidNodes() == 0) throw InputError("the lumen has no fluid node");
  const int margin = periodic ? static_cast<int>(std::ceil(imageReach / lattice->dx())) : 0;
  return std::make_unique<VoxelLumen>(std::move(lattice), margin);
}

}  // namespace packmesh::hemocell
