// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Threads of one rank that share the work of loops, and what they share.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <utility>
#include <vector>

namespace packmesh {

/// Number of cores that this process may use: those it is bound to (taskset, Slurm, mpirun), or fewer if its
/// control group has a quota (containers). At least 1.
int availableCores();

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

/// A loop whose items may take for ever unless they are stopped. Whether to stop is asked for on the thread
/// that begins the loop alone, and also while only other threads still have items.
class WatchedLoop {
 public:
  /// @param interrupted must outlive it, and not throw; empty: never stop
  WatchedLoop(const Threads& threads, const std::function<bool()>& interrupted)
      : threads_(threads), interrupted_(interrupted) {}

  /// Calls work(item, thread) as Threads::forEach() does.
  template <class Work>
  void forEach(std::int64_t items, Work&& work) {
    std::atomic<std::int64_t> next{0};
    threads_.forEach(std::min<std::int64_t>(threads_.count(), items), [&](std::int64_t, int thread) {
      begin();
      std::exception_ptr failure;
      try {
        for (std::int64_t item = next++; item < items; item = next++) work(item, thread);
      } catch (...) {
        failure = std::current_exception();
        next = items;
      }
      awaitOthers(thread);
      if (failure) std::rethrow_exception(failure);
    });
  }

  /// Whether to stop. Items poll it, with their thread.
  bool stops(int thread) {
    if (thread == 0 && interrupted_ && interrupted_()) stopped_ = true;
    return stopped_;
  }

 private:
  static constexpr std::chrono::milliseconds betweenPolls{50};

  void begin() {
    const std::lock_guard lock(mutex_);
    ++working_;
  }

  /// Nobody leaves while another one works: the first thread asks, and takes no part otherwise.
  void awaitOthers(int thread) {
    const auto allDone = [&] { return working_ == 0; };
    std::unique_lock lock(mutex_);
    --working_;
    changed_.notify_all();
    if (thread != 0) return changed_.wait(lock, allDone);
    while (!changed_.wait_for(lock, betweenPolls, allDone)) {
      lock.unlock();
      stops(0);
      lock.lock();
    }
  }

  Threads threads_;
  const std::function<bool()>& interrupted_;
  std::atomic<bool> stopped_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  int working_ = 0;  ///< threads that take items
};

/// Gives freed memory back to the system: other threads than the one that has freed it would not use it.
void returnFreedMemory();

}  // namespace packmesh
