// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/threads.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <fstream>
#include <limits>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#ifdef __linux__
#include <sched.h>
#endif

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace packmesh {
namespace {

int boundTo() {
#ifdef __linux__
  cpu_set_t set;
  if (sched_getaffinity(0, sizeof set, &set) == 0) return CPU_COUNT(&set);
#endif
  return static_cast<int>(std::thread::hardware_concurrency());
}

}  // namespace

int availableCores() {
  int cores = boundTo();
  // Version 2 of control groups: "200000 100000" stands for two cores, "max 100000" for no limit.
  double quota = 0.0, period = 0.0;
  if (std::ifstream("/sys/fs/cgroup/cpu.max") >> quota >> period && quota > 0.0 && period > 0.0)
    cores = std::min(cores, static_cast<int>(std::ceil(quota / period)));
  return std::max(1, cores);
}

namespace {

/// A thread that waits for the next loop, or for the end of one, first looks for it this many times without
/// sleeping: loops often follow each other within microseconds.
constexpr int looksBeforeSleep = 2000;

}  // namespace

struct Threads::Team {
  explicit Team(int most) : count(most), looks(most > cores ? 0 : looksBeforeSleep) {}

  /// Starts threads until there are `threads` with the calling one. Pre: no loop is running
  void grow(std::int64_t threads) {
    try {
      while (static_cast<std::int64_t>(others.size()) + 1 < threads) {
        const int thread = static_cast<int>(others.size()) + 1;
        others.emplace_back([this, thread, last = loop.load()] { serve(thread, last); });
      }
    } catch (const std::system_error&) {  // no resources for more: those there are do the work
      count = static_cast<int>(others.size()) + 1;
    }
  }

  ~Team() {
    if (!isHere()) {
      for (std::thread& other : others) other.detach();
      return;
    }
    {
      const std::lock_guard lock(mutex);
      over = true;
      ++loop;
    }
    begun.notify_all();
    for (std::thread& other : others) other.join();
  }

  /// False in a process that was forked: it has no other threads.
  bool isHere() const { return getpid() == process; }

  /// Does items until none is left.
  void help(int thread) {
    for (std::int64_t item = next++; item < items; item = next++) {
      try {
        (*work)(item, thread);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (item < failedItem) {
          failedItem = item;
          failure = std::current_exception();
        }
        next = items;
      }
    }
  }

  /// Waits until ready(), which others make true before they notify `by`.
  template <class Ready>
  void await(std::condition_variable& by, Ready&& ready) {
    for (int look = 0; look < looks; ++look) {
      if (ready()) return;
      std::this_thread::yield();
    }
    std::unique_lock lock(mutex);
    by.wait(lock, ready);
  }

  /// @param last number of the loop before the first one to help with
  void serve(int thread, std::int64_t last) {
    for (;;) {
      await(begun, [&] { return loop != last; });
      last = loop;
      if (over) return;
      help(thread);
      {
        const std::lock_guard lock(mutex);
        --busy;
      }
      ended.notify_one();
    }
  }

  void run(std::int64_t itemsOfLoop, const std::function<void(std::int64_t, int)>& workOfLoop) {
    grow(std::min<std::int64_t>(itemsOfLoop, count));
    {
      const std::lock_guard lock(mutex);
      work = &workOfLoop;
      items = itemsOfLoop;
      next = 0;
      failedItem = std::numeric_limits<std::int64_t>::max();
      busy = static_cast<int>(others.size());
      ++loop;
    }
    begun.notify_all();
    help(0);
    await(ended, [&] { return busy == 0; });
    if (failure) std::rethrow_exception(std::exchange(failure, nullptr));
  }

  const pid_t process = getpid();
  const int cores = availableCores();
  int count;        ///< of threads, at most
  const int looks;  ///< none if threads have to share cores
  std::vector<std::thread> others;
  std::mutex mutex;
  std::condition_variable begun, ended;
  std::atomic<std::int64_t> loop{0};  ///< number of the last one
  std::atomic<int> busy{0};           ///< other threads that have not ended it
  std::atomic<bool> over{false};

  const std::function<void(std::int64_t, int)>* work = nullptr;
  std::int64_t items = 0;
  std::atomic<std::int64_t> next{0};
  std::int64_t failedItem = 0;
  std::exception_ptr failure;
};

Threads::Threads(int count) : team_(count > 1 ? std::make_shared<Team>(count) : nullptr) {}

int Threads::count() const {
  return team_ ? team_->count : 1;
}

int Threads::atOnce() const {
  if (!team_ || !team_->isHere()) return 1;
  const int most = std::min(team_->count, team_->cores);
  team_->grow(most);
  return std::min(most, static_cast<int>(team_->others.size()) + 1);
}

void Threads::run(std::int64_t items, const std::function<void(std::int64_t, int)>& work) const {
  if (team_->isHere()) return team_->run(items, work);
  for (std::int64_t i = 0; i < items; ++i) work(i, 0);
}

void returnFreedMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace packmesh
