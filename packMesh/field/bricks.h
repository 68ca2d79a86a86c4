// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Sparse storage of values sampled at the nodes of a grid.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <vector>

#include "packMesh/field/brick_view.h"

namespace packmesh {

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

}  // namespace packmesh
