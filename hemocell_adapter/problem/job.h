// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Command line and config.xml put together: plain data that says completely what to do.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/case_config.h"
#include "hemocell_adapter/hemocell/case_source.h"
#include "hemocell_adapter/hemocell/cell_model.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/hemocell/pre_inlet.h"
#include "hemocell_adapter/settings/command_line.h"

namespace packmesh::hemocell {

/// One kind of cell, resolved: what it is made of and how its number is decided.
struct JobSpecies {
  enum class Template { model, mesh, ellipsoid };
  std::string name;
  Template kind = Template::model;
  CellModel model;                 ///< model
  std::filesystem::path meshFile;  ///< mesh
  double meshScale = 1.0;          ///< mesh: µm per unit of the file
  MeshFrame meshFrame = MeshFrame::hemocell;
  Vec3 ellipsoidAxes = Vec3::Zero();  ///< ellipsoid: full lengths [µm]
  std::string origin;                 ///< "RBC.xml, RBC_FROM_SPHERE", for people
  bool redCell = false;
  std::optional<std::int64_t> count;  ///< neither count nor ratio: the hematocrit decides
  std::optional<double> ratio;
  std::optional<double> statedDistanceFromSolid;  ///< by the configuration [µm]
  int minimumDistanceFromSolid = 0;               ///< as HemoCell has it [µm]
  std::string distanceFromSolidOrigin;            ///< "pipeflow.cpp:91", for people
  std::int64_t stock = 0;                         ///< so many more, when escaping
  std::vector<PosLine> fixed, start;              ///< cells that are there: that stay, or may move
  std::string fixedFrom, startFrom;               ///< files
  double ownWallClearance = 0.0;                  ///< of this species, where more than that of all [µm]
  std::optional<AxisCone> cone;
};

struct Job;

/// What cells of a species keep from the wall [µm].
double wallClearanceOf(const Job& job, const JobSpecies& species);

struct Job {
  Command command = Command::pack;
  bool asPackCells = false;
  std::optional<CaseConfig> config;  ///< a case
  CaseSource source;                 ///< of a case: its C++ code
  std::optional<Vec3> boxSize;       ///< a box from the command line [µm]
  std::optional<ContainerRequest> container;
  std::vector<JobSpecies> species;
  std::vector<RegionRequest> regions;

  double dx = 0.5;  ///< [µm]
  std::optional<double> hematocrit;
  std::optional<double> redCellVolume;  ///< [µm³]
  bool fluidVolume = false;
  std::optional<PreInletPlace> preInlet;
  std::optional<PreInletPlace> preInletInCode;  ///< what the code says, where another place is stated
  std::optional<bool> periodicEnds;
  std::optional<std::string> walls;
  bool keepAll = false;

  Method method = Method::relaxation;
  std::optional<PlaneSource> planeSource;       ///< of Method::cat
  bool escape = false;                          ///< of Method::cat
  GrowthSettings growth;                        ///< of Method::cat
  double clearance = 0.0, wallClearance = 0.0;  ///< demanded [µm]
  /// Not stated, so packing may keep more than is demanded (clearances.h).
  bool autoClearance = false, autoWallClearance = false;
  bool largestClearance = false;  ///< between membranes
  double cellFreeLayer = 0.0;     ///< of red cells [µm]
  std::uint64_t seed = 1;
  bool rotate = true;
  bool inColumns = false;                     ///< the cells with most volume start in columns
  double maxSeconds = 0.0;                    ///< 0: no limit
  std::optional<std::int64_t> maxIterations;  ///< empty: the method's own
  bool bestEffort = false;
  bool dryRun = false, validate = false;

  std::array<int, 3> tiles = {1, 1, 1};
  std::int64_t realisations = 1, firstRealisation = 1;
  std::vector<std::string> exports;
  std::filesystem::path outputDirectory;
  bool povScene = false;
  bool vtp = false, vtpMeshes = false;
  std::optional<std::filesystem::path> reportFile;  ///< .json, or .html with a .json beside it
  std::optional<std::filesystem::path> stateFile, restart;
  double checkpointEvery = 0.0;                       ///< [s]; 0: only at signals and in the end
  std::vector<std::string> commandWords;              ///< program and arguments, but for --restart
  std::vector<std::string> unchecked;                 ///< .pos files that `check` cannot examine
  std::vector<std::filesystem::path> foldersToCheck;  ///< `check` of realisations: each is a job of its own
  std::vector<std::string> warnings;  ///< what the user should know about how this was understood
};

/// packCells' convention: a red cell has 97 µm³.
constexpr double packCellsRedCellVolume = 97.0;

}  // namespace packmesh::hemocell
