// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A signed distance sampled on a sparse grid.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/core/vector.h"
#include "packMesh/field/interpolation.h"

namespace packmesh {

struct DistanceSample {
  double distance;  ///< [µm]
  Vec3 gradient;    ///< of the distance
};

/// Nodes of a grid: (i,j,k) is at origin + spacing * (i,j,k) [µm].
struct NodeBlock {
  Vec3 origin = Vec3::Zero();
  double spacing = 1.0;
  int nodes[3] = {0, 0, 0};

  Vec3 position(int i, int j, int k) const { return origin + spacing * Vec3(i, j, k); }
};

/// Source of the values of a SampledDistance.
class DistanceSource {
 public:
  virtual ~DistanceSource() = default;

  /// Distances [µm] at the nodes of a block, x fastest.
  virtual void sample(const NodeBlock& block, float* distances) const = 0;
};

/// The grid cell that contains a point, or the nearest point of the grid to it.
struct GridCell {
  int node[3];    ///< its low corner
  double t[3];    ///< position in the cell, 0 to 1 along each axis
  Vec3 beyond;    ///< from the nearest point of the grid to the point [cells]
  bool isBeyond;  ///< outside the grid

  /// @param u the point, relative to the first node [cells]
  /// @param cells of the grid along each axis, at least 1
  GridCell(const Vec3& u, const std::array<int, 3>& cells) : isBeyond(false) {
    for (int k = 0; k < 3; ++k) {
      const double last = cells[k], inside = u[k] > 0.0 ? std::min(u[k], last) : 0.0;
      node[k] = std::min(static_cast<int>(inside), cells[k] - 1);
      t[k] = inside - node[k];
      beyond[k] = u[k] - inside;
      isBeyond |= u[k] < 0.0 || u[k] > last;
    }
  }

  /// Interpolates between values with strides `row` along y and `slab` along z.
  /// @param valueAt returns the value at this offset from that of the low corner
  template <class ValueAt>
  Trilinear<double> interpolate(std::size_t row, std::size_t slab, ValueAt valueAt) const {
    double corner[8];
    for (int c = 0; c < 8; ++c) corner[c] = valueAt((c & 1) + (c & 2 ? row : 0) + (c & 4 ? slab : 0));
    return {corner, t};
  }
};

/// Bricks of nodes (BrickView), computed when they are first needed, so that time and memory depend on the
/// part of the grid that is used. Threads can share them.
/// @tparam Offset signed; large enough for the number of values
template <class Value, class Offset>
class Bricks {
 public:
  /// @param count number of bricks along each axis
  explicit Bricks(const std::array<int, 3>& count)
      : count_{count[0], count[1], count[2]}, begins_(std::size_t(count[0]) * count[1] * count[2], unknown) {}

  Bricks(const Bricks&) = delete;
  Bricks& operator=(const Bricks&) = delete;

  const int (&count() const)[3] { return count_; }
  std::size_t storedBricks() const { return stored_ / BrickView::nodes; }
  const Offset* begins() const { return begins_.data(); }  ///< see BrickView
  const Value* const* values() const { return &where_; }   ///< see BrickView

  /// The values at the nodes of a brick, x fastest; valid as long as this object.
  /// @param fill bool(Value*), called when the brick is first requested (by several threads at once, possibly
  ///   by each of them): if it returns false, nothing is stored, and the result is nullptr, now and later
  /// @throws std::length_error if Offset is too small
  template <class Fill>
  const Value* at(std::size_t index, const Fill& fill) {
    Offset begin = __atomic_load_n(&begins_[index], __ATOMIC_ACQUIRE);
    if (begin == unknown) begin = make(index, fill);
    return begin < 0 ? nullptr : __atomic_load_n(&where_, __ATOMIC_ACQUIRE) + begin;
  }

 private:
  static constexpr Offset unknown = -1, nothing = -2;
  static constexpr std::size_t fewest = 64 * BrickView::nodes;  ///< values of the first array

  template <class Fill>
  Offset make(std::size_t index, const Fill& fill) {
    std::array<Value, BrickView::nodes> made;
    const bool any = fill(made.data());
    const std::lock_guard lock(mutex_);
    if (begins_[index] == unknown)
      __atomic_store_n(&begins_[index], any ? add(made) : nothing, __ATOMIC_RELEASE);
    return begins_[index];
  }

  Offset add(const std::array<Value, BrickView::nodes>& made) {
    if (stored_ > std::size_t(std::numeric_limits<Offset>::max()) - BrickView::nodes)
      throw std::length_error("too many bricks");
    if (stored_ + made.size() >= capacity_) grow();
    std::copy(made.begin(), made.end(), &arrays_.back()[stored_]);
    const auto begin = static_cast<Offset>(stored_);
    stored_ += made.size();
    return begin;
  }

  /// Other threads may be reading the present array: it is kept. All earlier ones together are smaller.
  void grow() {
    capacity_ = std::max(fewest, 2 * capacity_);
    std::unique_ptr<Value[]> larger(
        new Value[capacity_ + 1]);  // not initialised: pages that are not used need no memory
    std::copy_n(where_, stored_, larger.get());
    __atomic_store_n(&where_, larger.get(), __ATOMIC_RELEASE);
    arrays_.push_back(std::move(larger));
  }

  int count_[3];
  std::vector<Offset> begins_;
  std::mutex mutex_;  ///< of what follows
  std::vector<std::unique_ptr<Value[]>> arrays_;
  const Value* where_ = nullptr;  ///< the last of them
  std::size_t stored_ = 0, capacity_ = 0;
};

/// Interpolates a distance between nodes at integer multiples of a spacing, in bricks that are computed when
/// they are first needed: time and memory depend on the wall's area near cells, not on the lumen's volume.
/// The result does not depend on the order of evaluations. Threads can share it.
class SampledDistance {
 public:
  /// @param source must outlive this
  /// @param region expected range of points; outside of it, the result is the distance at the nearest point
  ///   of the region minus the distance to that point
  /// @param spacing of the nodes [µm]
  /// @throws InputError if the region has more than 2^28 bricks of nodes
  SampledDistance(const DistanceSource& source, const Box& region, double spacing);

  SampledDistance(const SampledDistance&) = delete;
  SampledDistance& operator=(const SampledDistance&) = delete;

  DistanceSample sample(const Vec3& p) const;
  /// The same without its gradient [µm].
  double distance(const Vec3& p) const;

  double spacing() const { return spacing_; }
  /// Grid coordinates: bricks begin at integer multiples of BrickView::cells.
  Vec3 nodeOf(const Vec3& p) const { return p / spacing_ - lo_; }
  BrickView view() const;

 private:
  struct Place;
  const std::int16_t* brick(int index) const;

  const DistanceSource& source_;
  double spacing_;
  Vec3 lo_;  ///< node of the first brick
  mutable Bricks<std::int16_t, std::int32_t> bricks_;
};

}  // namespace packmesh
