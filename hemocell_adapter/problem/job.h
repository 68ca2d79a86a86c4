// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Command line and config.xml combined: plain data that specify the job completely.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/case_config.h"
#include "hemocell_adapter/hemocell/case_source.h"
#include "hemocell_adapter/hemocell/pre_inlet.h"
#include "hemocell_adapter/hemocell/running_case.h"
#include "hemocell_adapter/problem/cell_species.h"
#include "hemocell_adapter/settings/command_line.h"

namespace packmesh::hemocell {

/// Least gaps [µm].
struct Clearances {
  double membranes = 0.0, wall = 0.0;
};

/// The settings with everything that follows from them and from the case.
struct Job : RunSettings {
  Command command = Command::pack;
  bool asPackCells = false;
  std::optional<CaseConfig> config;  ///< a case
  CaseSource source;                 ///< of a case: its C++ code
  std::optional<Vec3> boxSize;       ///< a box from the command line [µm]
  std::shared_ptr<const RunningCase>
      running;  ///< inside a running HemoCell, which has the case; else nullptr
  std::vector<CellSpecies> species;
  std::optional<PreInletPlace> preInlet;
  std::optional<PreInletPlace> preInletInCode;  ///< place in the code, if a different one is stated

  Clearances demanded;  ///< 0 where none is stated
  /// Not specified, so that packing may keep more than demanded (clearances.h).
  bool autoClearance = false, autoWallClearance = false;
  bool outputStated = false;  ///< outputDirectory is not a default
  std::int64_t firstRealisation = 1;
  /// Of one of several realisations, its number and theirs; 0: there is only one.
  std::int64_t realisation = 0, realisationsOfAll = 0;
  std::vector<std::string> commandWords;              ///< see CommandLine::words
  std::vector<std::string> unchecked;                 ///< .pos files that `check` cannot examine
  std::vector<std::filesystem::path> foldersToCheck;  ///< `check` of realisations: each is a job of its own
  std::vector<std::string> warnings;                  ///< how the input was interpreted, for the user
};

/// packCells' convention: a red cell has 97 µm³.
constexpr double packCellsRedCellVolume = 97.0;

}  // namespace packmesh::hemocell
