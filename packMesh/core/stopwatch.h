// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file CPU time of the parts of a packing.
#pragma once

#include <ctime>

namespace packmesh {

/// CPU time of this process [s].
inline double cpuSeconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Adds the CPU time of a scope to a total.
class Stopwatch {
 public:
  explicit Stopwatch(double& total) : total_(total), start_(cpuSeconds()) {}
  ~Stopwatch() { total_ += cpuSeconds() - start_; }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& total_;
  double start_;
};

}  // namespace packmesh
