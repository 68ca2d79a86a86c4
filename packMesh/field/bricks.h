// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Sparse storage of values sampled at the nodes of a grid.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "packMesh/field/brick_view.h"

namespace packmesh {

/// Bricks of nodes (BrickView), computed when they are first needed, so that time and memory depend on the
/// part of the grid that is used. Not thread-safe.
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
  std::size_t storedValues() const { return values_.size(); }
  const Offset* begins() const { return begins_.data(); }  ///< see BrickView
  const Value* const* values() const { return &where_; }   ///< see BrickView

  /// The values at the nodes of a brick, x fastest; valid until the next brick is computed.
  /// @param fill bool(Value*), called at the first request for the brick: if it returns false, nothing is
  ///   stored, and the result is nullptr, now and later
  template <class Fill>
  const Value* at(std::size_t index, Fill fill) {
    if (begins_[index] == unknown) make(index, fill);
    return begins_[index] < 0 ? nullptr : where_ + begins_[index];
  }

 private:
  static constexpr Offset unknown = -1, nothing = -2;

  template <class Fill>
  void make(std::size_t index, Fill fill) {
    std::array<Value, BrickView::nodes> made;
    if (!fill(made.data())) {
      begins_[index] = nothing;
      return;
    }
    begins_[index] = static_cast<Offset>(values_.size() - 1);
    values_.insert(values_.end() - 1, made.begin(), made.end());
    where_ = values_.data();
  }

  int count_[3];
  std::vector<Offset> begins_;
  std::vector<Value> values_ = std::vector<Value>(1);
  const Value* where_ = nullptr;  ///< values_.data()
};

}  // namespace packmesh
