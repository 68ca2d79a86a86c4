// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Results of realisations: a row for each in realisations.csv.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "hemocell_adapter/base/exit_codes.h"

namespace packmesh::hemocell {

/// Figures of a packing that was written. Gaps above usualGapOfInterest, and to a wall if there is none, are
/// infinite.
struct RealisationFigures {
  bool complete = true;                                             ///< with all requested cells
  std::int64_t cells = 0;                                           ///< of all species
  double hematocrit = 0.0;                                          ///< of the lumen, by mesh volume
  double minimumGap = std::numeric_limits<double>::infinity();      ///< [µm]
  double minimumWallGap = std::numeric_limits<double>::infinity();  ///< [µm]
  std::int64_t sweeps = 0;                                          ///< with method cat: iterations
  double cpuSeconds = 0.0, wallSeconds = 0.0;                       ///< [s]
};

/// The rows of a series, and how many realisations were written.
class RealisationTable {
 public:
  /// Keeps the rows of realisations before `first` in an earlier file of the same series.
  /// @param seed of the first realisation of the series
  RealisationTable(const std::filesystem::path& file, std::int64_t first, std::uint64_t seed);

  /// @param figures used if `code` is ok
  void add(std::int64_t number, std::uint64_t seed, ExitCode code, const RealisationFigures& figures);

  std::string text() const;
  std::int64_t written() const;

 private:
  std::vector<std::string> rows_;
};

}  // namespace packmesh::hemocell
