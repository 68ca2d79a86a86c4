// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/memory.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>

#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

/// Measured as the difference in peak memory between 500,000 and 100,000 cells in a periodic box on one rank:
/// 912 bytes per cell if cells have hardly any neighbours (red cells at 0.02, platelets at 0.002), 1345 for
/// red cells at 0.2. The smallest value of any packing is used, so that nothing feasible is refused.
constexpr double bytesPerCell = 900.0;

constexpr double unlimited = std::numeric_limits<double>::infinity();

/// The first number in a file; infinite if there is none.
double numberIn(const std::string& file) {
  std::ifstream in(file);
  double number = 0.0;
  return in >> number ? number : unlimited;
}

/// MemAvailable of /proc/meminfo.
double leftOnMachine() {
  std::ifstream in("/proc/meminfo");
  std::string name, unit;
  for (double kilobytes = 0.0; in >> name >> kilobytes; std::getline(in, unit))
    if (name == "MemAvailable:") return 1024.0 * kilobytes;
  return unlimited;
}

/// Of control groups as containers and batch systems set them (versions 2 and 1).
double leftInGroup() {
  const double second = numberIn("/sys/fs/cgroup/memory.max") - numberIn("/sys/fs/cgroup/memory.current");
  const double first = numberIn("/sys/fs/cgroup/memory/memory.limit_in_bytes") -
                       numberIn("/sys/fs/cgroup/memory/memory.usage_in_bytes");
  const auto known = [](double left) { return left >= 0.0 ? left : unlimited; };  // false for NaN
  return std::min(known(second), known(first));
}

double leftOfAddressSpace() {
  rlimit limit = {};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unlimited;
  const double used = numberIn("/proc/self/statm") * static_cast<double>(sysconf(_SC_PAGESIZE));
  return std::max(0.0, static_cast<double>(limit.rlim_cur) - (used < unlimited ? used : 0.0));
}

/// Ranks on this machine, as stated by the launcher; otherwise all of them may be.
int ranksHere(const Communicator& ranks) {
  for (const char* variable : {"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS"})
    if (const char* text = std::getenv(variable))
      if (const int number = std::atoi(text); number > 0) return number;
  return ranks.size();
}

}  // namespace

double leastMemory(double cells) {
  return bytesPerCell * cells;
}

double availableMemory(const Communicator& ranks) {
  return std::min(std::min(leftOnMachine(), leftInGroup()) / ranksHere(ranks), leftOfAddressSpace());
}

void requireMemory(std::int64_t cells, const Communicator& ranks) {
  const double needed = leastMemory(static_cast<double>(cells) / ranks.size()), left = availableMemory(ranks);
  if (needed <= left) return;
  constexpr double gigabyte = 1e9;
  throw InputError(
      fmt::format("not enough memory: {} cells take at least {:.3g} GB on each of {} rank{}, and {:.3g} GB "
                  "are left for each. Request fewer cells or use more machines",
                  cells, needed / gigabyte, ranks.size(), ranks.size() == 1 ? "" : "s", left / gigabyte));
}

}  // namespace packmesh::hemocell
