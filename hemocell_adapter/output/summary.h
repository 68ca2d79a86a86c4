// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Introduction and summary of a run, for readers.
#pragma once

#include <string>
#include <vector>

#include "hemocell_adapter/output/packing.h"
#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// Version and interpretation of the input: lumen, species with the origin of their shapes, clearances, seed.
std::vector<std::string> headLines(const Problem& problem);

/// "HemoCell keeps", or who makes it keep them.
const char* keeperText(Loading loading);

/// The result: counts, volume fractions by every convention, gap, certificate, acceptance, times.
std::vector<std::string> footLines(const Packing& packing);

/// Description of the result if not all cells could be packed.
std::string reachedText(const Packing& packing);

/// What HemoCell starts with, of soft cells.
std::vector<std::string> deformationLines(const Deformations& deformations);

/// Where the cells of flowing blood are from. @param deformed cells of each species, of all ranks
std::vector<std::string> bloodLines(const Packing& packing, const std::vector<std::int64_t>& deformed);
/// Red cells and hematocrit of each region, by where their centres are. All ranks call.
std::vector<std::string> regionLines(const Packing& packing);

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

}  // namespace packmesh::hemocell
