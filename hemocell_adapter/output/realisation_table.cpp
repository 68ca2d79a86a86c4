// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/realisation_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace packmesh::hemocell {
namespace {

constexpr const char* head =
    "realisation,seed,outcome,cells,hematocrit,minimum_gap_um,minimum_wall_gap_um,sweeps,cpu_s,wall_s";

/// Empty if there is no such gap.
std::string gapField(double gap) {
  return std::isfinite(gap) ? fmt::format("{}", gap) : "";
}

std::string beginOf(std::int64_t number, std::uint64_t seed) {
  return fmt::format("{},{},", number, seed);
}

}  // namespace

RealisationTable::RealisationTable(const std::filesystem::path& file, std::int64_t first,
                                   std::uint64_t seed) {
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line) || line != head) return;
  const auto columns = std::count(line.begin(), line.end(), ',');
  while (std::getline(in, line)) {
    if (std::count(line.begin(), line.end(), ',') != columns) continue;
    for (std::int64_t i = 1; i < first; ++i)
      if (line.rfind(beginOf(i, seed + std::uint64_t(i - 1)), 0) == 0) rows_.push_back(line);
  }
}

void RealisationTable::add(std::int64_t number, std::uint64_t seed, ExitCode code,
                           const RealisationFigures& f) {
  const std::string begin = beginOf(number, seed);
  if (code != ExitCode::ok)
    rows_.push_back(begin + "failed,,,,,,,");
  else
    rows_.push_back(begin + fmt::format("{},{},{},{},{},{},{:.3f},{:.3f}",
                                        f.complete ? "certified" : "bestEffort", f.cells, f.hematocrit,
                                        gapField(f.minimumGap), gapField(f.minimumWallGap), f.sweeps,
                                        f.cpuSeconds, f.wallSeconds));
}

std::string RealisationTable::text() const {
  return fmt::format("{}\n{}\n", head, fmt::join(rows_, "\n"));
}

std::int64_t RealisationTable::written() const {
  return std::count_if(rows_.begin(), rows_.end(),
                       [](const std::string& row) { return row.find(",failed,") == std::string::npos; });
}

}  // namespace packmesh::hemocell
