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
  SurfaceBuilder(const Lattice& lattice, bool periodic) : lattice_(lattice), periodic_(periodic) {
    const auto [nx, ny, nz] = lattice.nodes();
    for (auto& layer : layers_) layer.assign(std::size_t(nx + 1) * (ny + 1), -1);
  }

  TriangleMesh build() {
    const auto [nx, ny, nz] = lattice_.nodes();
    for (int k = 0; k <= nz; ++k) {
      for (int j = 0; j <= ny; ++j)
        for (int i = 0; i <= nx; ++i) facesBelow(i, j, k);
      std::swap(layers_[0], layers_[1]);
      layers_[1].assign(layers_[1].size(), -1);
    }
    return std::move(mesh_);
  }

 private:
  bool fluid(int i, int j, int k) const {
    const auto [nx, ny, nz] = lattice_.nodes();
    if (periodic_) i = (i + nx) % nx;
    return i >= 0 && i < nx && j >= 0 && j < ny && k >= 0 && k < nz && lattice_.fluid(i, j, k);
  }

  /// Adds the faces of node (i, j, k) towards the lower neighbour on each axis.
  void facesBelow(int i, int j, int k) {
    if (periodic_ && i == lattice_.nodes()[0]) return;  // same as plane 0
    const bool here = fluid(i, j, k);
    const std::array<bool, 3> below = {fluid(i - 1, j, k), fluid(i, j - 1, k), fluid(i, j, k - 1)};
    for (int axis = 0; axis < 3; ++axis)
      if (here != below[axis]) face({i, j, k}, axis, below[axis]);
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
    const std::size_t row = static_cast<std::size_t>(lattice_.nodes()[0]) + 1;
    int& number = layers_[p[2] - slab][p[0] + row * p[1]];
    if (number < 0) {
      number = static_cast<int>(mesh_.vertices.size());
      mesh_.vertices.push_back(lattice_.dx() * (Vec3(p[0], p[1], p[2]).array() - 0.5));
    }
    return number;
  }

  const Lattice& lattice_;
  bool periodic_;
  std::array<std::vector<int>, 2> layers_;  ///< numbers of corners, -1: none yet
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh voxelSurface(const Lattice& lattice, bool periodic) {
  return SurfaceBuilder(lattice, periodic).build();
}

}  // namespace packmesh::hemocell
