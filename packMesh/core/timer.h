// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file CPU and wall-clock time.
#pragma once

#include <sys/resource.h>

#include <chrono>
#include <ctime>

namespace packmesh {

/// CPU time of this process and its terminated child processes [s].
inline double cpuSeconds() {
  const auto secondsOf = [](int who) {
    rusage used{};
    getrusage(who, &used);
    return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);  // µs
  };
  return secondsOf(RUSAGE_SELF) + secondsOf(RUSAGE_CHILDREN);
}

/// Measures time since its construction.
class Timer {
 public:
  Timer() = default;
  /// On destruction adds the CPU time since construction to `total` [s].
  explicit Timer(double& total) : total_(&total) {}
  ~Timer() {
    if (total_) *total_ += cpu();
  }
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;

  double cpu() const { return cpuSeconds() - cpuStart_; }  ///< [s]
  double wall() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }  ///< [s]

 private:
  double* total_ = nullptr;
  double cpuStart_ = cpuSeconds();
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

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
