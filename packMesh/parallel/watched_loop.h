// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Loops over items that wait for other programs.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>

#include "packMesh/parallel/threads.h"

namespace packmesh {

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

}  // namespace packmesh
