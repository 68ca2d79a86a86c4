// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The cases of growth_benchmark. A file with cases registers them by a static AddCases.
#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "packMesh/core/timer.h"

namespace packmesh::benchmark {

struct Options {
  std::filesystem::path folder;  ///< for plots and meshes; empty: none wanted
  int seeds = 1;                 ///< packings are made with seeds 1 to this
  bool check = false;            ///< pack once more and certify every accepted state
};

struct Case {
  std::string name, about;
  std::function<void(const Options&)> run;
};

inline std::vector<Case>& allCases() {
  static std::vector<Case> cases;
  return cases;
}

struct AddCases {
  explicit AddCases(const std::vector<Case>& cases) {
    allCases().insert(allCases().end(), cases.begin(), cases.end());
  }
};

/// CPU time of a call [s].
template <class Work>
double timeOf(Work&& work) {
  const double start = cpuSeconds();
  work();
  return cpuSeconds() - start;
}

inline double medianOf(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

}  // namespace packmesh::benchmark
