// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Introduction and summary of a run, for readers.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/problem.h"
#include "packMesh/packing/packing_result.h"

namespace packmesh::hemocell {

/// Version and interpretation of the input: lumen, species with the origin of their shapes, clearances, seed.
std::vector<std::string> headLines(const Problem& problem);

/// Times of a run [s].
struct RunTimes {
  double cpu = 0.0, wall = 0.0;
};

/// Number of cells in `cells` that HemoCell keeps, per species.
struct Kept {
  Loading loading = Loading::posFiles;
  std::vector<std::int64_t> kept;
  std::vector<double> excess;  ///< of these cells, see excessVolumes() [µm³]
  std::vector<std::pair<std::string, std::int64_t>>
      reasons;  ///< why the others are deleted, with their number

  /// Whether the others do nothing but cross a periodic face.
  bool asExpected() const {
    return std::all_of(reasons.begin(), reasons.end(), [](const auto& one) { return isExpected(one.first); });
  }
};

/// "HemoCell keeps", or who makes it keep them.
const char* keeperText(Loading loading);

/// The result: counts, volume fractions by every convention, gap, certificate, acceptance, times.
/// @param clearances that were kept @param tally of what was (or would be) written, with its certificate
std::vector<std::string> footLines(const Problem& problem, const Clearances& clearances, const Tally& tally,
                                   const Certificate& certificate, const Kept& kept, const RunTimes& times);

/// Description of the result if not all cells could be packed.
std::string reachedText(const Problem& problem, const PackingResult& result, const Tally& tally);

/// Where the cells of flowing blood are from. @param counts of the species, and of their deformed cells
std::vector<std::string> bloodLines(const Problem& problem, const std::vector<Part>& parts,
                                    const std::vector<std::int64_t>& counts,
                                    const std::vector<std::int64_t>& deformed);
/// Red cells and hematocrit of each region, by where their centres are. @param counts of the parts
std::vector<std::string> regionLines(const Problem& problem, const std::vector<Part>& parts,
                                     const std::vector<std::int64_t>& counts);

/// What was reached of a profile, shell by shell. @param reached reachedProfile(). Pre: there is a profile
std::vector<std::string> profileLines(const Problem& problem,
                                      const std::vector<std::vector<double>>& reached);

/// Statistics of packing: sweeps or iterations, repairs or rejected steps, CPU time of the stages.
std::vector<std::string> effortLines(const Statistics& statistics);

/// One of the conventions for the volume of a red cell.
struct HematocritConvention {
  const char* key;      ///< for programs
  std::string text;     ///< for people
  double volume = 0.0;  ///< of all red cells [µm³]
};
std::vector<HematocritConvention> hematocritConventions(const Request& request, const Tally& tally);

/// "Hematocrit 0.4001 of the lumen by mesh volume, ...": the same cells by every convention.
std::vector<std::string> hematocritLines(const Problem& problem, const Tally& tally);

/// "by hematocrit", "12 requested", "0.07 per red cell": how the number of cells was specified.
std::string requestText(const CellSpecies& species);

/// "RBC: minimum distance from solid 1 µm (pipeflow.cpp:91)".
std::string distanceLine(const CellSpecies& species);

/// "packMesh 1.0.0 (0123456789), 1 rank".
std::string versionLine(int ranks, int threads);

/// "0.0213 µm", "more than 1 µm".
std::string gapText(double gap, double measuredUpTo);

/// "Lumen: periodic box 50 x 50 x 50 µm", volumes, lattice.
std::vector<std::string> lumenLines(const Problem& problem);

/// Adds `reason` with this number of occurrences to the list of reasons.
void countReason(Kept& kept, const std::string& reason, std::int64_t times);

}  // namespace packmesh::hemocell
