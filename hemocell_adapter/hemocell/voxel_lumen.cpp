// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/voxel_lumen.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "hemocell_adapter/hemocell/voxel_distance.h"
#include "packMesh/core/error.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/mesh_tree.h"
#include "packMesh/parallel/threads.h"

namespace packmesh::hemocell {
namespace {

/// Distances beyond the ends of a periodic lumen take its images into account up to this far from the ends
/// [µm]: more than the radius of any blood cell, and than the blocks in which distances are sampled.
constexpr double imageReach = 16.0;

/// Edge of the blocks of nodes whose faces are put into one hierarchy when a cell is near [nodes].
constexpr int nodesPerBlock = 16;

class VoxelLumen final : public Container, public Wall {
 public:
  VoxelLumen(std::shared_ptr<const Lattice> lattice, const std::array<bool, 3>& periodic)
      : lattice_(std::move(lattice)),
        periodic_(periodic),
        margin_(marginsOf(*lattice_, periodic)),
        repeated_(margin_ != std::array<int, 3>{}
                      ? std::make_unique<const Lattice>(lattice_->repeated(margin_))
                      : nullptr),
        voxels_(repeated_ ? *repeated_ : *lattice_),
        lo_(lattice_->keptRegion().lo),
        bounds_(boundsOf(*lattice_, periodic)) {}

  Box bounds() const override { return bounds_; }
  Vec3 period() const override {
    Vec3 period = Vec3::Zero();
    for (int k = 0; k < 3; ++k)
      if (periodic_[k]) period[k] = length(k);
    return period;
  }
  double volume() const override { return lattice_->fluidVolume(); }
  const Wall* wall() const override { return this; }
  TriangleMesh surface() const override { return voxelSurface(*lattice_, periodic_); }

  double spacing() const { return lattice_->dx(); }

  std::string describe() const override {
    const Vec3 size = bounds_.size();
    std::string axes;
    for (int k = 0; k < 3; ++k)
      if (periodic_[k]) axes += axes.empty() ? std::string(1, "xyz"[k]) : fmt::format(", {}", "xyz"[k]);
    return fmt::format("{} fluid nodes in {:.6g} x {:.6g} x {:.6g} µm, {}", lattice_->fluidNodes(), size.x(),
                       size.y(), size.z(), axes.empty() ? "closed" : "periodic along " + axes);
  }

  WallDistance distance(const Vec3& p) const override { return voxels_.at(inFrame(p)); }
  WallDistance smoothed(const Vec3& p) const override { return voxels_.smoothed(inFrame(p)); }
  double smoothReach() const override { return voxels_.smoothReach(); }
  double slack() const override { return voxels_.slack(); }
  double samplingSpacing() const override { return 0.5 * lattice_->dx(); }

  void sample(const NodeBlock& block, float* distances) const override {
    NodeBlock moved = block;
    const Vec3 middle = block.position(block.nodes[0] / 2, block.nodes[1] / 2, block.nodes[2] / 2);
    moved.origin += inFrame(middle) - middle;
    voxels_.sample(moved, distances);
  }

  WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest) const override {
    WallVerdict verdict;
    Box box;
    for (std::size_t i = 0; i < cell.vertexCount(); ++i) box.add(cell.vertex(i));
    double nearest = gapOfInterest;
    bool encloses = false;
    forEachHierarchy(
        box.grownBy(gapOfInterest + tolerance::culling), [&](const MeshHierarchy& faces, const Vec3& shift) {
          const Placement image{Mat3::Identity(), shift};
          const double gap = surfaceGap(cell.hierarchy, cell.placement, faces, image, nearest);
          nearest = std::min(nearest, gap);
          if (gap == 0.0) {
            verdict.violation = "meets the wall";
            return false;
          }
          for (const int v : faces.tree().samples) {
            const Vec3 sample = image(faces.mesh().vertices[v]);
            encloses = encloses || (box.contains(sample) && isInside(sample, cell.hierarchy, cell.placement));
          }
          return true;
        });
    if (verdict.violation) return verdict;
    for (const int v : cell.hierarchy.tree().samples)
      if (!contains(cell.vertex(v))) verdict.violation = "is outside the lumen";
    if (!verdict.violation && encloses) verdict.violation = "encloses part of the wall";
    if (!verdict.violation && nearest < gapOfInterest) verdict.gap = nearest;
    return verdict;
  }

 private:
  static std::array<int, 3> marginsOf(const Lattice& lattice, const std::array<bool, 3>& periodic) {
    std::array<int, 3> margins{};
    for (int k = 0; k < 3; ++k)
      if (periodic[k]) margins[k] = static_cast<int>(std::ceil(imageReach / lattice.dx()));
    return margins;
  }

  /// Around the fluid nodes; one period along periodic axes.
  static Box boundsOf(const Lattice& lattice, const std::array<bool, 3>& periodic) {
    const auto [first, last] = *lattice.fluidRange();
    const double dx = lattice.dx();
    Box box = {dx * (Vec3(first[0], first[1], first[2]).array() - 0.5),
               dx * (Vec3(last[0] + 1, last[1] + 1, last[2] + 1).array() - 0.5)};
    for (int k = 0; k < 3; ++k) {
      if (!periodic[k]) continue;
      box.lo[k] = lattice.keptRegion().lo[k];
      box.hi[k] = lattice.keptRegion().hi[k];
    }
    return box;
  }

  double length(int axis) const { return lattice_->nodes()[axis] * lattice_->dx(); }

  /// The image of the lumen along an axis that contains x; 0 if it is not periodic.
  int imageOf(double x, int axis) const {
    return periodic_[axis] ? static_cast<int>(std::floor((x - lo_[axis]) / length(axis))) : 0;
  }

  /// Position of p in the repeated lattice: in its central period, if the lumen repeats.
  Vec3 inFrame(Vec3 p) const {
    for (int k = 0; k < 3; ++k)
      if (periodic_[k]) p[k] += (margin_[k] - imageOf(p[k], k) * lattice_->nodes()[k]) * lattice_->dx();
    return p;
  }

  /// Pre: p is not on the surface.
  bool contains(const Vec3& p) const { return voxels_.at(inFrame(p)).distance > 0.0; }

  /// Calls visit(faces, shift) for the hierarchies of all blocks of nodes that a box meets, in every image of
  /// the lumen, as long as it returns true. `shift` moves them there.
  template <class Visit>
  void forEachHierarchy(const Box& box, Visit&& visit) const {
    std::array<int, 3> firstImage, lastImage;
    for (int k = 0; k < 3; ++k) {
      firstImage[k] = imageOf(box.lo[k], k);
      lastImage[k] = imageOf(box.hi[k], k);
    }
    for (int z = firstImage[2]; z <= lastImage[2]; ++z)
      for (int y = firstImage[1]; y <= lastImage[1]; ++y)
        for (int x = firstImage[0]; x <= lastImage[0]; ++x) {
          const Vec3 shift(x * length(0), y * length(1), z * length(2));
          if (!forEachHierarchyOfPeriod({box.lo - shift, box.hi - shift}, shift, visit)) return;
        }
  }

  template <class Visit>
  bool forEachHierarchyOfPeriod(const Box& box, const Vec3& shift, Visit& visit) const {
    std::array<int, 3> first, last;  // blocks
    for (int k = 0; k < 3; ++k) {
      const auto blockAt = [&](double p) {  // faces are at the low sides of nodes 0 ... n
        const double node = std::floor(p / lattice_->dx() + 0.5);
        return static_cast<int>(std::clamp(node, 0.0, double(lattice_->nodes()[k]))) / nodesPerBlock;
      };
      first[k] = blockAt(box.lo[k]);
      last[k] = blockAt(box.hi[k]);
    }
    for (int k = first[2]; k <= last[2]; ++k)
      for (int j = first[1]; j <= last[1]; ++j)
        for (int i = first[0]; i <= last[0]; ++i)
          if (const MeshHierarchy* faces = facesOf({i, j, k}); faces && !visit(*faces, shift)) return false;
    return true;
  }

  /// The faces of a block of nodes; nullptr if there are none.
  const MeshHierarchy* facesOf(const std::array<int, 3>& block) const {
    return faces_
        .at(block,
            [&] {
              std::array<int, 3> first, last;
              for (int k = 0; k < 3; ++k) {
                first[k] = nodesPerBlock * block[k];
                last[k] = std::min(first[k] + nodesPerBlock - 1, lattice_->nodes()[k]);
              }
              const TriangleMesh mesh = voxelSurface(*lattice_, periodic_, first, last);
              return mesh.triangles.empty() ? nullptr : std::make_unique<const MeshHierarchy>(mesh);
            })
        .get();
  }

  std::shared_ptr<const Lattice> lattice_;
  std::array<bool, 3> periodic_;
  std::array<int, 3> margin_;  ///< nodes repeated at either end of periodic axes
  std::unique_ptr<const Lattice> repeated_;
  VoxelDistance voxels_;
  Vec3 lo_;  ///< low corner of the lattice's voxels [µm]
  Box bounds_;
  mutable MadeOnce<std::array<int, 3>, std::unique_ptr<const MeshHierarchy>> faces_;  ///< by block
};

}  // namespace

std::unique_ptr<Container> makeVoxelLumen(std::shared_ptr<const Lattice> lattice,
                                          const std::array<bool, 3>& periodic) {
  if (!lattice->hasFluidNodes()) throw InputError("the lumen has no fluid node");
  return std::make_unique<VoxelLumen>(std::move(lattice), periodic);
}

std::optional<double> voxelSpacing(const Container& lumen) {
  const auto* voxels = dynamic_cast<const VoxelLumen*>(&lumen);
  return voxels ? std::optional(voxels->spacing()) : std::nullopt;
}

namespace {

/// Collects faces slab by slab along z, so that vertex numbers of only two layers are kept.
class SurfaceBuilder {
 public:
  SurfaceBuilder(const Lattice& lattice, const std::array<bool, 3>& periodic, const std::array<int, 3>& first,
                 const std::array<int, 3>& last)
      : lattice_(lattice),
        periodic_(periodic),
        first_(first),
        last_(last),
        rowLength_(static_cast<std::size_t>(last[0] - first[0]) + 2) {
    for (auto& layer : layers_) layer.assign(rowLength_ * (last[1] - first[1] + 2), -1);
  }

  TriangleMesh build() {
    for (int k = first_[2]; k <= last_[2]; ++k) {
      for (int j = first_[1]; j <= last_[1]; ++j)
        for (int i = first_[0]; i <= last_[0]; ++i) facesBelow({i, j, k});
      std::swap(layers_[0], layers_[1]);
      layers_[1].assign(layers_[1].size(), -1);
    }
    return std::move(mesh_);
  }

 private:
  bool fluid(std::array<int, 3> at) const {
    const std::array<int, 3> nodes = lattice_.nodes();
    for (int a = 0; a < 3; ++a) {
      if (periodic_[a]) at[a] = (at[a] + nodes[a]) % nodes[a];
      if (at[a] < 0 || at[a] >= nodes[a]) return false;
    }
    return lattice_.fluid(at[0], at[1], at[2]);
  }

  /// Adds the faces of a node towards the lower neighbour on each axis.
  void facesBelow(const std::array<int, 3>& at) {
    for (int a = 0; a < 3; ++a)
      if (periodic_[a] && at[a] == lattice_.nodes()[a]) return;  // same as plane 0
    const bool here = fluid(at);
    for (int axis = 0; axis < 3; ++axis) {
      std::array<int, 3> lower = at;
      --lower[axis];
      if (const bool below = fluid(lower); here != below) face(at, axis, below);
    }
  }

  /// Adds the face at the low side of a node along an axis.
  /// @param upwards true if its normal points along the axis: the fluid is below
  void face(const std::array<int, 3>& at, int axis, bool upwards) {
    int corner[4];
    for (int c = 0; c < 4; ++c) {
      std::array<int, 3> p = at;
      p[(axis + 1) % 3] += c == 1 || c == 2;
      p[(axis + 2) % 3] += c >= 2;
      corner[c] = vertex(p, at[2]);
    }
    if (!upwards) std::swap(corner[1], corner[3]);
    mesh_.triangles.push_back({corner[0], corner[1], corner[2]});
    mesh_.triangles.push_back({corner[0], corner[2], corner[3]});
  }

  /// @param slab layers_[0] is the layer of corners p with p[2] = slab
  int vertex(const std::array<int, 3>& p, int slab) {
    int& number = layers_[p[2] - slab][(p[0] - first_[0]) + rowLength_ * (p[1] - first_[1])];
    if (number < 0) {
      number = static_cast<int>(mesh_.vertices.size());
      mesh_.vertices.push_back(lattice_.dx() * (Vec3(p[0], p[1], p[2]).array() - 0.5));
    }
    return number;
  }

  const Lattice& lattice_;
  std::array<bool, 3> periodic_;
  std::array<int, 3> first_, last_;
  std::size_t rowLength_;                   ///< of layers_
  std::array<std::vector<int>, 2> layers_;  ///< numbers of corners, -1: none yet
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh voxelSurface(const Lattice& lattice, const std::array<bool, 3>& periodic) {
  return voxelSurface(lattice, periodic, {0, 0, 0}, lattice.nodes());
}

TriangleMesh voxelSurface(const Lattice& lattice, const std::array<bool, 3>& periodic,
                          const std::array<int, 3>& first, const std::array<int, 3>& last) {
  return SurfaceBuilder(lattice, periodic, first, last).build();
}

}  // namespace packmesh::hemocell
