// SPDX-License-Identifier: AGPL-3.0-or-later
#include <array>
#include <utility>
#include <vector>

#include "hemocell_adapter/hemocell/voxel_lumen.h"

namespace packmesh::hemocell {
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
