// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Several packings of one problem, each with its own seed and folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/problem/completed_request.h"
#include "packMesh/parallel/communicator.h"

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

/// Result of a run.
struct RunEnd {
  ExitCode code = ExitCode::ok;
  RealisationFigures figures;  ///< if a packing was written
};

/// Runs the realisations of a request in sequence, starting with the first or with outputs.realisation if
/// that is larger, the very first with its seed, in their folders (realisationFolder) of its folder.
/// `restart` applies to the first one that is run. A failure does not prevent the remaining ones from
/// running; an interruption does. Means and standard deviations are printed and the figures of each
/// realisation written to realisations.csv; those of realisations made before are taken from there. All ranks
/// call.
/// @return ok if all are; otherwise the code of the first that failed
ExitCode runRealisations(const CompletedRequest& series, const OutputRequest& outputs,
                         const Communicator& ranks,
                         const std::function<RunEnd(const CompletedRequest&, const OutputRequest&)>& run);

}  // namespace packmesh::hemocell
