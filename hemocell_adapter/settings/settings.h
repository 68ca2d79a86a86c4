// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What the user can ask for, however it was asked: command line or `<packing>` section.
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

/// One kind of cell as asked for. Where a member is empty the name decides (see job.h).
struct SpeciesRequest {
  std::string name;
  std::optional<std::int64_t> count;
  std::optional<double> ratio;  ///< cells of this kind per red cell of any kind
  std::optional<Construction> construction;
  /// As passed to setInitialMinimumDistanceFromSolid, which truncates it to a whole number [µm].
  std::optional<double> minimumDistanceFromSolid;
  std::optional<std::filesystem::path> meshFile;
  std::optional<double> meshScale;  ///< µm per unit of the mesh file
  std::optional<MeshFrame> meshFrame;
  std::optional<Vec3> ellipsoidAxes;  ///< full lengths [µm]
  std::optional<bool> redCell;        ///< whether its volume counts as hematocrit
  std::optional<std::int64_t> stock;  ///< cells beyond those asked for, to fill gaps with when escaping
  std::optional<std::filesystem::path> fixed;  ///< .pos file of cells that stay
  std::optional<std::filesystem::path> start;  ///< .pos file of cells that are there, but may move
  std::optional<double> wallClearance;         ///< [µm]
  std::optional<Vec3> axis;                    ///< of the cell's thin axis, any length
  std::optional<double> spread;                ///< [degrees] around it
};

/// A body with a closed surface, in the .pos frame [µm].
struct SolidRequest {
  enum class Kind { box, cylinder, sphere, mesh };
  Kind kind = Kind::box;
  Vec3 size = Vec3::Zero();           ///< box [µm]
  Vec3 origin = Vec3::Zero();         ///< box: its low corner; mesh: added after scaling [µm]
  std::optional<Vec3> center;         ///< cylinder, sphere [µm]; default: touching the planes x, y, z = 0
  int axis = 0;                       ///< cylinder
  double radius = 0.0, length = 0.0;  ///< [µm]
  std::filesystem::path file;         ///< mesh
  double scale = 1.0;                 ///< mesh: µm per unit of the file
  std::optional<int> openAxis;        ///< mesh: axis along which the lumen is open
  std::string where;                  ///< "config.xml:12: <cylinder>" or "option '--cylinder'"
};

/// A lumen of the user's own: a body from which obstacles are subtracted.
struct ContainerRequest {
  std::optional<SolidRequest> lumen;  ///< empty: the box of `<domain>` or of the command line
  std::vector<SolidRequest> obstacles;
  std::optional<Vec3> nodes;  ///< lattice nodes of the case when its XML does not say
};

/// A part of the lumen with a hematocrit of its own.
struct RegionRequest {
  double hematocrit = 0.0;
  SolidRequest body;
};

/// What is asked for and holds as it stands; members begin with their defaults.
struct RunSettings {
  std::optional<double> hematocrit;
  std::optional<double> redCellVolume;  ///< volume by which red cells are counted [µm³]; empty: of the mesh
  bool fluidVolume = false;             ///< hematocrit of the fluid-node volume instead of the true lumen
  std::optional<ContainerRequest> container;
  std::vector<RegionRequest> regions;  ///< a point belongs to the first one that it is in
  double cellFreeLayer = 0.0;          ///< red cells keep this far from the wall [µm]
  std::optional<bool> periodicEnds;
  std::optional<std::string> walls;  ///< sorted letters of the axes that end in walls
  bool keepAll = false;
  double dx = 0.5;  ///< [µm]; with a case, that of its XML
  std::array<int, 3> tiles = {1, 1, 1};

  Method method = Method::relaxation;
  PlaneSource planeSource = PlaneSource::chords;  ///< of Method::cat
  bool escape = false;                            ///< of Method::cat
  GrowthSettings growth;                          ///< of Method::cat
  bool largestClearance = false;                  ///< as much between membranes as can be found
  std::uint64_t seed = 1;
  bool rotate = true;
  bool inColumns = false;                     ///< the cells with most volume start in columns
  double maxSeconds = 0.0;                    ///< 0: no limit
  std::optional<std::int64_t> maxIterations;  ///< empty: the method's own
  bool bestEffort = false;
  bool dryRun = false, validate = false;  ///< say what would be done; only check the input

  std::int64_t realisations = 1;
  std::vector<std::string> exports;
  std::filesystem::path outputDirectory;  ///< empty: where the case is, or the working directory
  std::optional<std::filesystem::path> stateFile, restart;
  double checkpointEvery = 0.0;  ///< [s]; 0: only at signals and in the end
  bool povScene = false, vtp = false, vtpMeshes = false;
  std::optional<std::filesystem::path> reportFile;  ///< .json, or .html with a .json beside it
  bool quiet = false, verbose = false;
};

/// Everything that can be asked for.
struct Settings : RunSettings {
  std::optional<double> plateletRatio;  ///< empty: packCellsPlateletRatio, where there may be platelets
  std::vector<SpeciesRequest> species;
  std::optional<std::string> preInlet;  ///< direction of HemoCell's pre-inlet, "Xpos"
  std::optional<NodePlane> preInletSlice;
  std::vector<NodeRange> preInletRanges;           ///< what of that plane is the inlet; one for each axis
  std::optional<double> clearance, wallClearance;  ///< [µm]; empty: as much as is cheap
  std::optional<double> ignoredScale;              ///< packCells' --scale was given
  bool checkBox = false;                           ///< `check --box`

  std::set<std::string> stated;  ///< names of the settings (Setting::name()) that someone asked for
  bool states(const std::string& name) const { return stated.count(name) > 0; }
};

/// Platelets per red cell that packCells adds to a hematocrit.
constexpr double packCellsPlateletRatio = 0.07;

/// Names of the formats that cells can be exported in.
inline constexpr const char* exportFormats[] = {"csv", "lammps", "mirheo"};

/// More kinds of cells than this are a slip.
constexpr std::size_t mostSpecies = 10'000;

/// @throws InputError when there is no room for another one
void requireRoomForSpecies(const Settings& settings);

/// The request for cells called `name`, added when there is none yet. @throws InputError when there are too
/// many
SpeciesRequest& speciesNamed(Settings& settings, const std::string& name);

/// The same, nullptr when there is none.
const SpeciesRequest* findSpecies(const Settings& settings, const std::string& name);

}  // namespace packmesh::hemocell
