// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Settings of a run, from the command line or the `<packing>` section.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "hemocell_adapter/base/node_plane.h"
#include "hemocell_adapter/settings/construction.h"
#include "packMesh/core/vector.h"
#include "packMesh/packing/packing_problem.h"

namespace packmesh::hemocell {

/// One requested species. Empty members have defaults that depend on the name (see job.h).
struct SpeciesRequest {
  std::string name;
  std::optional<std::int64_t> count;
  std::optional<double> ratio;  ///< cells of this species per red cell of any species
  std::optional<Construction> construction;
  /// Argument of setInitialMinimumDistanceFromSolid, which truncates it to an integer [µm].
  std::optional<double> minimumDistanceFromSolid;
  std::optional<std::filesystem::path> meshFile;
  std::optional<double> meshScale;  ///< µm per unit of the mesh file
  std::optional<MeshFrame> meshFrame;
  std::optional<Vec3> ellipsoidAxes;           ///< full lengths [µm]
  std::optional<bool> redCell;                 ///< true if its volume counts in the hematocrit
  std::optional<std::int64_t> stock;           ///< with escape: number of cells in reserve that can fill gaps
  std::optional<std::filesystem::path> fixed;  ///< .pos file of fixed cells
  std::optional<std::filesystem::path> start;  ///< .pos file of existing cells that can move
  std::optional<double> wallClearance;         ///< [µm]
  std::optional<Vec3> axis;                    ///< direction of the cells' symmetry axis, any length
  std::optional<double> spread;                ///< largest angle to `axis` [degrees]
};

/// A body with a closed surface, in the coordinate system of .pos files [µm].
struct SolidRequest {
  enum class Kind { box, cylinder, sphere, mesh };
  Kind kind = Kind::box;
  Vec3 size = Vec3::Zero();           ///< box [µm]
  Vec3 origin = Vec3::Zero();         ///< box: low corner; mesh: added after scaling [µm]
  std::optional<Vec3> center;         ///< cylinder, sphere [µm]; default: touching the planes x, y, z = 0
  int axis = 0;                       ///< cylinder: direction, 0, 1, 2 = x, y, z
  double radius = 0.0, length = 0.0;  ///< [µm]
  std::filesystem::path file;         ///< mesh
  double scale = 1.0;                 ///< mesh: µm per unit of the file
  std::optional<int> openAxis;        ///< mesh: axis along which the lumen is open
  std::string where;                  ///< for messages: "config.xml:12: <cylinder>" or "option '--cylinder'"
};

/// A user-defined lumen: a body from which obstacles are subtracted.
struct ContainerRequest {
  std::optional<SolidRequest> lumen;  ///< empty: the box given by `<domain>` or the command line
  std::vector<SolidRequest> obstacles;
  std::optional<Vec3> nodes;  ///< lattice nodes of the case, if not in its XML
};

/// A part of the lumen with its own hematocrit.
struct RegionRequest {
  double hematocrit = 0.0;
  SolidRequest body;
};

/// Settings used without further processing; the initial values of members are the defaults.
struct RunSettings {
  std::optional<double> hematocrit;
  std::optional<double> redCellVolume;  ///< of one red cell in the hematocrit [µm³]; empty: of its mesh
  bool fluidVolume = false;  ///< hematocrit refers to the volume of the fluid nodes, not of the true lumen
  std::optional<ContainerRequest> container;
  std::vector<RegionRequest> regions;  ///< a point belongs to the first region that contains it
  double cellFreeLayer = 0.0;          ///< minimum distance between red cells and the wall [µm]
  bool capOpenings = true;             ///< close flat openings of the mesh of a vessel
  std::optional<bool> periodicEnds;
  std::optional<std::string> walls;  ///< axes that end in walls, as sorted letters
  bool keepAll = false;
  double dx = 0.5;  ///< lattice spacing [µm]; a case has it in its XML
  std::array<int, 3> tiles = {1, 1, 1};

  Method method = Method::relaxation;
  PlaneSource planeSource = PlaneSource::chords;  ///< of Method::cat
  bool escape = false;                            ///< of Method::cat
  GrowthSettings growth;                          ///< of Method::cat
  bool largestClearance = false;                  ///< maximise the gap between membranes
  std::uint64_t seed = 1;
  bool rotate = true;
  bool inColumns = false;                     ///< the species with the largest volume starts in columns
  double maxSeconds = 0.0;                    ///< 0: no limit
  std::optional<std::int64_t> maxIterations;  ///< empty: default of the method
  std::optional<std::int64_t> threads;        ///< of each rank; empty: teamOf() decides
  bool bestEffort = false;
  bool dryRun = false, validate = false;  ///< print what would be done; only check the input

  std::int64_t realisations = 1;
  std::vector<std::string> exports;
  std::filesystem::path outputDirectory;  ///< empty: folder of the case, or the working directory
  std::optional<std::filesystem::path> stateFile, restart;
  double checkpointEvery = 0.0;  ///< [s]; 0: only at signals and at the end
  bool povScene = false, vtp = false, vtpMeshes = false;
  bool writesVtp() const { return vtp || povScene; }  ///< pictures are made of these files
  std::int64_t growthFrames = 0;                      ///< interval in states of growth; 0: none are written
  std::optional<std::filesystem::path> reportFile;    ///< .json, or .html together with a .json file
  bool quiet = false, verbose = false;
};

/// All settings.
struct Settings : RunSettings {
  /// State files with existing cells of any species.
  std::vector<std::filesystem::path> fixedStates, startStates;
  std::optional<double> plateletRatio;  ///< empty: packCellsPlateletRatio, where there may be platelets
  std::vector<SpeciesRequest> species;
  std::optional<std::string> preInlet;  ///< direction of HemoCell's pre-inlet, "Xpos"
  std::optional<NodePlane> preInletSlice;
  std::vector<NodeRange> preInletRanges;           ///< part of that plane that is the inlet; one per axis
  std::optional<double> clearance, wallClearance;  ///< [µm]; empty: as large as possible at little cost
  std::optional<double> ignoredScale;              ///< value of packCells' --scale
  bool checkBox = false;                           ///< `check --box`

  std::set<std::string> stated;  ///< names (Setting::name()) of the settings given by the user
  bool states(const std::string& name) const { return stated.count(name) > 0; }
};

/// Platelets per red cell that packCells adds to a hematocrit.
constexpr double packCellsPlateletRatio = 0.07;

/// Whether a file of existing cells is a state, by its name; otherwise it is a .pos file.
inline bool isState(const std::filesystem::path& file) {
  return file.extension() == ".h5";
}

/// Names of the export formats.
inline constexpr const char* exportFormats[] = {"csv",    "espresso", "lammps", "lammps-molecular",
                                                "mirheo", "npfem",    "stl"};

/// A larger number of species is probably an error.
constexpr std::size_t mostSpecies = 10'000;

/// @throws InputError if there are already `mostSpecies` species
void requireRoomForSpecies(const Settings& settings);

/// The request for the species `name`, added if there is none yet. @throws InputError if there are too many
SpeciesRequest& speciesNamed(Settings& settings, const std::string& name);

/// The request for the species `name`, nullptr if there is none.
const SpeciesRequest* findSpecies(const Settings& settings, const std::string& name);

}  // namespace packmesh::hemocell
