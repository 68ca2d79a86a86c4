// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Values that are made when they are first needed and shared by threads.
#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <shared_mutex>
#include <utility>

namespace packmesh {

/// A map whose values are made when they are first read. A value is never changed or moved.
template <class Key, class Value>
class MadeOnce {
 public:
  /// @param make Value(), called if there is no value yet (by several threads at once, possibly by each of
  ///   them); may read other objects of this kind, but not this one
  template <class Make>
  const Value& at(const Key& key, const Make& make) {
    {
      const std::shared_lock lock(mutex_);
      if (const auto found = values_.find(key); found != values_.end()) return found->second;
    }
    Value made = make();
    const std::unique_lock lock(mutex_);
    return values_.try_emplace(key, std::move(made)).first->second;
  }

  std::size_t size() const {
    const std::shared_lock lock(mutex_);
    return values_.size();
  }

 private:
  mutable std::shared_mutex mutex_;
  std::map<Key, Value> values_;
};

}  // namespace packmesh
