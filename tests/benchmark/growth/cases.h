// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The cases of growth_benchmark.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "packMesh/core/timer.h"

namespace packmesh {
struct TetrahedraInput;
}

namespace packmesh::benchmark {

struct Options {
  int seeds = 1;       ///< packings are made with seeds 1 to this
  bool check = false;  ///< pack once more and certify every accepted state
};

struct Case {
  std::string name, about;
  std::function<void(const Options&)> run;
};

std::vector<Case> packingCases();  ///< whole packings
std::vector<Case> partCases();     ///< parts of an iteration, and tetrahedra

/// CPU time of a call [s].
template <class Work>
double timeOf(Work&& work) {
  const double start = cpuSeconds();
  work();
  return cpuSeconds() - start;
}

/// CPU time of one plain `tetgen -p` run [s]: TetGen's own program does just this between reading and writing
/// files.
double plainTetgenSeconds(const TetrahedraInput& input);

}  // namespace packmesh::benchmark
