// SPDX-License-Identifier: AGPL-3.0-or-later
// Distance transform by lower envelopes, one axis after the other (Felzenszwalb and Huttenlocher, Theory of
// Computing 8, 2012), for distances to cubes instead of points.
#include <algorithm>
#include <cmath>
#include <limits>

#include "hemocell_adapter/voxel_distance.h"

namespace packmesh::hemocell {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

/// One axis. The squared distance from x to a cube around q with squared distance f(q) across the axis is
/// f(q) + max(|x - q| - 1/2, 0)²; for whole x ≠ q that is a parabola around the nearer face of the cube, q ±
/// 1/2. The other face's parabola is above it, so the minimum over all faces, and over f(x) itself, is the
/// distance.
class AxisPass {
 public:
  explicit AxisPass(int length) : apex_(length + 1), value_(length + 1), from_(length + 2) {}

  /// out[s] = squared distance at x = step·s, for f[0..length).
  void operator()(const float* f, int length, int step, float* out, int samples) {
    count_ = 0;
    for (int face = 0; face <= length; ++face) {
      const float lower = face > 0 ? f[face - 1] : infinite, upper = face < length ? f[face] : infinite;
      const float value = std::min(lower, upper);
      if (value != infinite) add(face - 0.5, value);
    }
    int e = 0;
    for (int s = 0; s < samples; ++s) {
      const int x = step * s;
      while (e + 1 < count_ && from_[e + 1] <= x) ++e;
      const double away = count_ > 0 ? x - apex_[e] : 0.0;
      const float envelope = count_ > 0 ? static_cast<float>(value_[e] + away * away) : infinite;
      out[s] = x < length ? std::min(f[x], envelope) : envelope;
    }
  }

 private:
  void add(double apex, double value) {
    while (count_ > 0) {
      const double other = apex_[count_ - 1];
      const double cross = 0.5 * (apex + other + (value - value_[count_ - 1]) / (apex - other));
      if (cross > from_[count_ - 1]) {
        from_[count_] = cross;
        break;
      }
      --count_;
    }
    if (count_ == 0) from_[0] = -std::numeric_limits<double>::infinity();
    apex_[count_] = apex;
    value_[count_++] = value;
  }

  std::vector<double> apex_, value_, from_;  ///< parabola e is lowest from from_[e] to from_[e + 1]
  int count_ = 0;
};

/// Squared distances from the samples to the cubes of the nodes with fluid() == kind.
std::vector<float> squaredDistance(const Lattice& lattice, bool kind, int step,
                                   const std::array<int, 3>& samples) {
  const auto [nx, ny, nz] = lattice.nodes();
  const auto [sx, sy, sz] = samples;
  AxisPass pass(std::max({nx, ny, nz}));
  // z last, so that only reduced slices are kept.
  std::vector<float> slices(std::size_t(sx) * sy * nz), slice(std::size_t(sx) * ny);
  std::vector<float> line(std::max({nx, ny, nz})), reduced(std::max({sx, sy, sz}));
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) line[i] = lattice.fluid(i, j, k) == kind ? 0.0f : infinite;
      pass(line.data(), nx, step, &slice[std::size_t(sx) * j], sx);
    }
    for (int i = 0; i < sx; ++i) {
      for (int j = 0; j < ny; ++j) line[j] = slice[i + std::size_t(sx) * j];
      pass(line.data(), ny, step, reduced.data(), sy);
      for (int j = 0; j < sy; ++j) slices[i + std::size_t(sx) * (j + std::size_t(sy) * k)] = reduced[j];
    }
  }
  std::vector<float> result(std::size_t(sx) * sy * sz);
  const std::size_t plane = std::size_t(sx) * sy;
  for (std::size_t column = 0; column < plane; ++column) {
    for (int k = 0; k < nz; ++k) line[k] = slices[column + plane * k];
    pass(line.data(), nz, step, reduced.data(), sz);
    for (int k = 0; k < sz; ++k) result[column + plane * k] = reduced[k];
  }
  return result;
}

}  // namespace

std::vector<float> voxelTransform(const Lattice& inside, int step, const std::array<int, 3>& samples) {
  std::vector<float> toInside = squaredDistance(inside, true, step, samples);
  const std::vector<float> toOutside = squaredDistance(inside, false, step, samples);
  const std::array<int, 3> nodes = inside.nodes();
  const double furthest = double(nodes[0]) + nodes[1] + nodes[2];  // for a lattice without any inside
  std::size_t index = 0;
  for (int k = 0; k < samples[2]; ++k)
    for (int j = 0; j < samples[1]; ++j)
      for (int i = 0; i < samples[0]; ++i, ++index) {
        const int node[3] = {step * i, step * j, step * k};
        double rim = std::numeric_limits<double>::infinity();
        for (int axis = 0; axis < 3; ++axis)
          rim = std::min(rim, std::min(node[axis] + 0.5, nodes[axis] - 0.5 - node[axis]));
        const double outward = std::min(furthest, std::sqrt(double(toInside[index])));
        toInside[index] = outward > 0.0 || rim < 0.0
                              ? static_cast<float>(-outward)
                              : static_cast<float>(std::min(rim, std::sqrt(double(toOutside[index]))));
      }
  return toInside;
}

}  // namespace packmesh::hemocell
