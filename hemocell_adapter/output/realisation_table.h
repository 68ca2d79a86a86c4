// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Results of realisations: a row for each in realisations.csv, means and standard deviations for the
/// summary.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "hemocell_adapter/base/exit_codes.h"

namespace packmesh::hemocell {

/// Figures of a packing that was written. Gaps above gapOfInterest, and to a wall if there is none, are
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

struct Realisation {
  std::int64_t number = 1;
  std::uint64_t seed = 1;
  ExitCode code = ExitCode::ok;
  RealisationFigures figures;  ///< when written

  bool written() const { return code == ExitCode::ok; }
};

/// Text of realisations.csv: a header, then one row each.
std::string realisationsText(const std::vector<Realisation>& rows);

/// The rows of realisations before `first` in a file written by realisationsText for the same seeds; none if
/// there is no such file. @param seed of the first realisation of the series
std::vector<Realisation> readRealisations(const std::filesystem::path& file, std::int64_t first,
                                          std::uint64_t seed);

/// Mean, standard deviation (of a sample), least and largest of each figure, as text; empty for fewer than
/// two packings.
std::vector<std::string> realisationLines(const std::vector<Realisation>& rows);

}  // namespace packmesh::hemocell
