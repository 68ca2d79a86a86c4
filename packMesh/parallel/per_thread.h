// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Values that the threads of a rank write at the same time, each its own.
#pragma once

#include <vector>

#include "packMesh/parallel/threads.h"

namespace packmesh {

/// A value for each thread. They are far enough apart in memory that threads do not slow each other down by
/// writing to them (false sharing of cache lines, which processors fetch in pairs).
template <class Value>
class PerThread {
 public:
  explicit PerThread(const Threads& threads, const Value& initial = {})
      : slots_(threads.count(), {initial}) {}

  Value& operator[](int thread) { return slots_[thread].value; }
  /// Calls visit(value), thread by thread.
  template <class Visit>
  void forEach(Visit&& visit) const {
    for (const Slot& slot : slots_) visit(slot.value);
  }

 private:
  struct alignas(128) Slot {
    Value value;
  };
  std::vector<Slot> slots_;
};

}  // namespace packmesh
