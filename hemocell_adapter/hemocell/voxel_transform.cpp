// SPDX-License-Identifier: AGPL-3.0-or-later
// Distance transform by lower envelopes, one axis after the other (Felzenszwalb and Huttenlocher, Theory of
// Computing 8, 2012), for distances to cubes from their corners.
#include <algorithm>
#include <cmath>
#include <limits>

#include "hemocell_adapter/hemocell/voxel_distance.h"

namespace packmesh::hemocell {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

/// One axis. From a corner at integer x, the distance to a cube [q, q+1] is that to the nearer of its faces q
/// and q+1, so the squared distance is the lower envelope of parabolas around the faces.
class AxisPass {
 public:
  explicit AxisPass(int length) : apex_(length + 1), value_(length + 1), from_(length + 2) {}

  /// out[s·outStride] = squared distance at x = step·s, for cubes with squared distances f[q·stride] across.
  void operator()(const float* f, std::size_t stride, int length, int step, float* out, std::size_t outStride,
                  int samples) {
    count_ = 0;
    float lower = infinite;
    for (int face = 0; face <= length; ++face) {
      const float upper = face < length ? f[face * stride] : infinite, value = std::min(lower, upper);
      if (value != infinite) add(face, value);
      lower = upper;
    }
    if (count_ == 0) {
      for (int s = 0; s < samples; ++s) out[s * outStride] = infinite;
      return;
    }
    int e = 0;
    for (int s = 0; s < samples; ++s) {
      const float x = static_cast<float>(step * s);
      while (e + 1 < count_ && from_[e + 1] <= x) ++e;
      out[s * outStride] = value_[e] + (x - apex_[e]) * (x - apex_[e]);
    }
  }

 private:
  void add(int apex, float value) {
    while (count_ > 0) {
      const float other = apex_[count_ - 1];
      const float cross = 0.5f * (apex + other + (value - value_[count_ - 1]) / (apex - other));
      if (cross > from_[count_ - 1]) {
        from_[count_] = cross;
        break;
      }
      --count_;
    }
    if (count_ == 0) from_[0] = -infinite;
    apex_[count_] = static_cast<float>(apex);
    value_[count_++] = value;
  }

  std::vector<float> apex_, value_, from_;  ///< parabola e is lowest from from_[e] to from_[e + 1]
  int count_ = 0;
};

/// Squared distances along a row of nodes to those with fluid() == kind, at x = step·s.
void rowDistances(const std::uint64_t* row, int nodes, bool kind, int step, float* out, int samples,
                  std::vector<int>& distance) {
  bool all = step * (samples - 1) <= nodes, none = true;
  for (int w = 0; w < (nodes + 63) / 64; ++w) {
    const std::uint64_t used = usedBits(nodes, w);
    const std::uint64_t bits = (kind ? row[w] : ~row[w]) & used;
    all = all && bits == used;
    none = none && bits == 0;
  }
  if (all || none) {
    std::fill(out, out + samples, all ? 0.0f : infinite);
    return;
  }
  const int far = std::numeric_limits<int>::max() / 2, last = step * (samples - 1);
  distance.resize(std::max(last, nodes) + 1);
  const auto has = [&](int i) {
    return i >= 0 && i < nodes && (row[i >> 6] >> (i & 63) & 1u) == (kind ? 1u : 0u);
  };
  const int end = static_cast<int>(distance.size());
  int away = far;
  for (int x = 0; x < end; ++x) {
    away = has(x - 1) || has(x) ? 0 : std::min(away + 1, far);
    distance[x] = away;
  }
  away = far;
  for (int x = end - 1; x >= 0; --x) {
    away = distance[x] == 0 ? 0 : std::min(away + 1, far);
    distance[x] = std::min(distance[x], away);
  }
  for (int s = 0; s < samples; ++s) {
    const float d = static_cast<float>(distance[step * s]);
    out[s] = distance[step * s] < far / 2 ? d * d : infinite;
  }
}

/// Squared distances from the samples to the cubes of the nodes with fluid() == kind.
std::vector<float> squaredDistance(const Lattice& lattice, bool kind, int step,
                                   const std::array<int, 3>& samples) {
  const auto [nx, ny, nz] = lattice.nodes();
  const auto [sx, sy, sz] = samples;
  AxisPass pass(std::max({nx, ny, nz}));
  // z last, so that only reduced slices are stored.
  const std::size_t plane = std::size_t(sx) * sy;
  std::vector<float> slices(plane * nz), slice(std::size_t(sx) * ny), result(plane * sz);
  std::vector<int> scratch;
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j)
      rowDistances(lattice.row(j, k), nx, kind, step, &slice[std::size_t(sx) * j], sx, scratch);
    for (int i = 0; i < sx; ++i) pass(&slice[i], sx, ny, step, &slices[plane * k + i], sx, sy);
  }
  for (std::size_t column = 0; column < plane; ++column)
    pass(&slices[column], plane, nz, step, &result[column], plane, sz);
  return result;
}

}  // namespace

std::vector<float> voxelTransform(const Lattice& inside, int step, const std::array<int, 3>& samples) {
  std::vector<float> toInside = squaredDistance(inside, true, step, samples);
  const std::vector<float> toOutside = squaredDistance(inside, false, step, samples);
  const std::array<int, 3> nodes = inside.nodes();
  const float furthest =
      static_cast<float>(nodes[0]) + nodes[1] + nodes[2];  // for a lattice without fluid nodes
  std::size_t index = 0;
  for (int k = 0; k < samples[2]; ++k)
    for (int j = 0; j < samples[1]; ++j)
      for (int i = 0; i < samples[0]; ++i, ++index) {
        const int corner[3] = {step * i, step * j, step * k};
        int rim = std::numeric_limits<int>::max();
        for (int axis = 0; axis < 3; ++axis) rim = std::min({rim, corner[axis], nodes[axis] - corner[axis]});
        const float outward = std::min(furthest, std::sqrt(toInside[index]));
        const float inward = std::min(static_cast<float>(std::max(rim, 0)), std::sqrt(toOutside[index]));
        toInside[index] = outward > 0.0f ? -outward : inward;
      }
  return toInside;
}

}  // namespace packmesh::hemocell
