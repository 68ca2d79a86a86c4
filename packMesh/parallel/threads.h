// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Threads of one rank that share the work of loops.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>

namespace packmesh {

/// The threads of one rank. Copies refer to the same threads, which end with the last copy.
///
/// A loop is shared item by item, in any order, so its items must be independent of each other; its result
/// must not depend on which thread does an item. Loops are begun by one thread at a time, never from within
/// another loop, and only the thread that begins them uses MPI. In a forked process that thread is alone.
class Threads {
 public:
  /// The calling thread alone.
  Threads() = default;
  /// The calling thread and up to `count` - 1 others. They are started when a loop has items for them: there
  /// are never more than the longest loop had items, and fewer if the system permits no more. Pre: count >= 1
  explicit Threads(int count);

  /// The largest number of threads of a loop; the number of those that PerThread needs values for.
  int count() const;
  bool alone() const { return team_ == nullptr; }

  /// Items of a loop may wait for each other if it has no more of them than this: then each has a thread of
  /// its own, and the threads have a core each as far as other programs permit. Starts the threads.
  int atOnce() const;

  /// Calls work(item, thread) once for each item of 0 ... items - 1, where `thread` is that of the thread, 0
  /// ... count() - 1 (0: the calling one).
  /// @throws what work() throws, of the smallest such item among those begun; then others may be left out
  template <class Work>
  void forEach(std::int64_t items, Work&& work) const {
    if (alone() || items < 2) {
      for (std::int64_t i = 0; i < items; ++i) work(i, 0);
      return;
    }
    run(items, std::ref(work));
  }

  /// The same for items that take little time: calls work(begin, end, thread) for parts of 0 ... items - 1.
  template <class Work>
  void forEachPart(std::int64_t items, Work&& work, std::int64_t part = 1024) const {
    forEach((items + part - 1) / part,
            [&](std::int64_t p, int thread) { work(p * part, std::min(items, (p + 1) * part), thread); });
  }

 private:
  void run(std::int64_t items, const std::function<void(std::int64_t, int)>& work) const;

  struct Team;
  std::shared_ptr<Team> team_;
};

}  // namespace packmesh
