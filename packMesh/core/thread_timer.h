// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file CPU time of one thread.
#pragma once

#include <ctime>

namespace packmesh {

/// On destruction adds the CPU time that the calling thread has used since construction to `total` [s].
class ThreadTimer {
 public:
  explicit ThreadTimer(double& total) : total_(total) {}
  ~ThreadTimer() { total_ += now() - start_; }
  ThreadTimer(const ThreadTimer&) = delete;
  ThreadTimer& operator=(const ThreadTimer&) = delete;

 private:
  static double now() {
    timespec used{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
    return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);  // ns
  }

  double& total_;
  double start_ = now();
};

}  // namespace packmesh
