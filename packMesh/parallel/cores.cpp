// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/cores.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <thread>

#ifdef __linux__
#include <sched.h>
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

}  // namespace packmesh
