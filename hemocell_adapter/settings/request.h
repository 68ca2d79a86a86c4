// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The request of a user, from the command line, the `<packing>` section, or Python.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/base/value.h"
#include "packMesh/cat/cat_settings.h"
#include "packMesh/core/vector.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {
struct StateCells;
struct StateTable;
class Communicator;
}  // namespace packmesh

namespace packmesh::hemocell {

/// How HemoCell constructs the template; named as in the case's C++ code.
enum class Construction { rbcFromSphere, ellipsoidFromSphere, wbcSphere, meshFromStl };

/// `RBC_FROM_SPHERE`, `ELLIPSOID_FROM_SPHERE`, `WBC_SPHERE`, `MESH_FROM_STL`.
std::string toString(Construction construction);
std::optional<Construction> constructionFromString(const std::string& text);
/// All names.
std::vector<std::string> constructionNames();

/// Axes of a mesh file without `<Cell>.xml`: rotated as by MESH_FROM_STL, or as in the file.
enum class MeshFrame { hemocell, file };

/// `hemocell`, `file`.
std::string toString(MeshFrame frame);
std::vector<std::string> meshFrameNames();
std::optional<MeshFrame> meshFrameFromString(const std::string& text);

/// Numbers that a front end gives instead of a file: a mesh has the tables "vertices" (3 columns, in the unit
/// of the request) and "triangles" (3), a profile one of a column for each of its own, lines of .pos files
/// one of 6 columns for each kind of cell; cells of a state those of storedCells().
struct MemoryInput {
  std::string key;   ///< its name in JSON and in states, unique in a request
  std::string what;  ///< the setting, with which messages begin (messages.h)
  std::vector<StateTable> tables;

  const StateTable* find(std::string_view name) const;  ///< nullptr: there is none
  /// @throws InputError if there is none, or none with so many columns
  const StateTable& table(std::string_view name, int columns) const;
};
/// By their keys.
using MemoryInputs = std::map<std::string, std::shared_ptr<const MemoryInput>>;

/// A file or numbers in memory. Messages name it by string().
struct Source {
  Source() = default;
  Source(std::filesystem::path path) : file(std::move(path)) {}
  Source(const std::string& path) : file(path) {}
  Source(const char* path) : file(path) {}
  Source(std::shared_ptr<const MemoryInput> numbers) : file(numbers->what), given(std::move(numbers)) {}

  std::filesystem::path file;  ///< with numbers: what messages call them
  std::shared_ptr<const MemoryInput> given;

  bool empty() const { return file.empty(); }
  std::string string() const { return file.string(); }
};
inline bool operator==(const Source& a, const Source& b) {
  return a.file == b.file && a.given == b.given;
}

/// Whether a source of existing cells is a state, by the name of the file; otherwise it has lines of .pos
/// files.
bool isState(const Source& source);

/// The mesh, as readMesh() reads it. @throws InputError
TriangleMesh meshFrom(const Source& source, std::vector<std::string>* notes = nullptr);

/// The cells of a state; of numbers in memory all ranks have them, and this one's share is returned. All
/// ranks call. @throws InputError
StateCells cellsFrom(const Source& source, const Communicator& ranks, bool withMeshes = true);

/// Cells of a state as numbers. Pre: all of them
std::vector<StateTable> storedCells(const StateCells& state);

/// Where a value was stated.
struct Origin {
  /// What is stated later in this list overrides what is stated earlier; the last three are front ends.
  /// argument: of a section that the program is given as one.
  enum class Kind { section, argument, state, option, keyword, member };
  Kind kind = Kind::option;
  std::string place;  ///< for messages, of a section: "config.xml:12: <walls>"; empty: its name says it

  bool isLaterThan(const Origin& other) const { return rank() > other.rank(); }
  bool isSection() const { return kind == Kind::section || kind == Kind::argument; }

 private:
  int rank() const { return isSection() ? 0 : kind == Kind::state ? 1 : 2; }
};
/// By what they are of: "walls" (Setting::key()), "species.RBC.count", "container", "regions".
using Origins = std::map<std::string, Origin>;

/// Least gaps [µm].
struct Clearances {
  double membranes = 0.0, wall = 0.0;
};

/// One requested species. Empty members have defaults that depend on the name (see species_plans.h).
struct SpeciesRequest {
  std::string name;
  std::optional<std::int64_t> count;
  std::optional<double> ratio;  ///< cells of this species per red cell of any species
  std::optional<Construction> construction;
  /// Argument of setInitialMinimumDistanceFromSolid, which truncates it to an integer [µm].
  std::optional<double> minimumDistanceFromSolid;
  std::optional<Source> meshFile;
  std::optional<double> meshScale;  ///< µm per unit of the mesh file
  std::optional<MeshFrame> meshFrame;
  std::optional<Vec3> ellipsoidAxes;    ///< full lengths [µm]
  std::optional<bool> redCell;          ///< true if its volume counts in the hematocrit
  std::optional<std::int64_t> stock;    ///< number of cells in reserve that can fill gaps
  std::optional<Source> fixed;          ///< lines of a .pos file of fixed cells
  std::optional<Source> start;          ///< of existing cells that can move
  std::optional<double> wallClearance;  ///< [µm]
  std::optional<Vec3> axis;             ///< direction of the cells' symmetry axis, any length
  std::optional<double> spread;         ///< largest angle to `axis` [degrees]
  std::optional<bool> rigid;            ///< true if its cells keep their shape beside soft ones
  bool inBlood = false;                 ///< the state Request::blood has such cells
};

/// A body with a closed surface, or for regions a part of the lumen beyond a plane or a cut, in the
/// coordinate system of .pos files [µm].
struct SolidRequest {
  enum class Kind { box, cylinder, sphere, mesh, halfSpace, beyond };
  Kind kind = Kind::box;
  Vec3 size = Vec3::Zero();           ///< box [µm]
  Vec3 origin = Vec3::Zero();         ///< box: low corner; mesh: added after scaling [µm]
  std::optional<Vec3> center;         ///< cylinder, sphere [µm]; default: touching the planes x, y, z = 0
  int axis = 0;                       ///< cylinder: direction, 0, 1, 2 = x, y, z
  double radius = 0.0, length = 0.0;  ///< [µm]
  Vec3 point = Vec3::Zero();          ///< halfSpace, beyond [µm]
  Vec3 direction = Vec3::Zero();      ///< halfSpace, beyond: into the region, any length
  Source file;                        ///< mesh
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

/// Cells of one species that are in a region, beside those in the whole lumen.
struct RegionSpecies {
  std::string name;
  std::int64_t count = 0;
};

/// A part of the lumen with its own hematocrit or number of red cells, or with cells of its own.
struct RegionRequest {
  std::optional<double> hematocrit;
  std::optional<std::int64_t> count;  ///< of red cells of all species
  SolidRequest body;
  std::vector<RegionSpecies> species;

  /// Whether it has red cells of its own, so that the others are not free to be in it.
  bool statesRedCells() const { return hematocrit || count; }
};

/// What is written beside the cells, and where. Only writers and the session look at it.
struct OutputRequest {
  std::filesystem::path folder;  ///< of the .pos files; empty: folder of the case, or the working directory
  std::vector<std::string> exports;
  std::optional<std::filesystem::path> stateFile;
  double checkpointEvery = 0.0;  ///< [s]; 0: only at signals and at the end
  bool povScene = false, vtp = false, vtpMeshes = false;
  bool undeformed = false;  ///< in formats that hold poses, deformed cells are written undeformed
  bool writesVtp() const { return vtp || povScene; }  ///< pictures are made of these files
  std::int64_t frames = 0;                          ///< interval in states of the engine; 0: none are written
  std::optional<std::filesystem::path> reportFile;  ///< .json, or .html together with a .json file
  /// Of one of several realisations, its number and theirs; 0: there is only one.
  std::int64_t realisation = 0, realisationsOfAll = 0;

  bool asksForViews() const { return !exports.empty() || writesVtp() || vtpMeshes || reportFile; }
};

/// How a packing is sought.
struct Method {
  enum Kind {
    relaxation,  ///< full-size cells are placed at random and pushed apart
    cat,         ///< small cells grow in the cells of the chordal axis transform (thesis chapter 3)
  };
};

/// Whether cells may deform.
enum class Deforming {
  no,
  unlessEasy,  ///< unless undeformed ones can be packed easily
  asLast,      ///< only if undeformed ones cannot be packed with all effort
};

/// Whether packMesh was built with Method::cat (CMake: PACKMESH_CAT).
bool hasCat();

/// The working directory, empty if it was removed.
std::filesystem::path currentFolder();

/// What the user states, nothing resolved; the initial values of members are the defaults. Made by the
/// readers of one table of settings: options, `<packing>`, JSON.
struct Request {
  std::optional<std::filesystem::path> config;            ///< config.xml of a case
  std::filesystem::path workingFolder = currentFolder();  ///< relative names of files begin there
  // Cells
  std::optional<double> hematocrit;
  std::optional<double> dischargeHematocrit;  ///< decides the hematocrit, by the lumen's diameter
  std::optional<double> plateletRatio;        ///< empty: packCellsPlateletRatio, where there may be platelets
  std::vector<SpeciesRequest> species;
  std::vector<Source> fixedStates, startStates;  ///< states with cells of any species
  std::optional<Source> blood;                   ///< state whose cells are repeated over the lumen
  std::optional<double> redCellVolume;  ///< of one red cell in the hematocrit [µm³]; empty: of its mesh
  bool fluidVolume = false;  ///< hematocrit refers to the volume of the fluid nodes, not of the true lumen
  bool packCellsConventions = false;  ///< started as packCells: its volumes, ends and rounding

  // Lumen
  std::optional<Vec3> boxSize;  ///< a box beside a case [µm]
  std::optional<ContainerRequest> container;
  std::vector<RegionRequest> regions;  ///< a point belongs to the first region that contains it
  /// File with the distribution of cells over the distance from the wall, or developedProfile.
  std::optional<Source> profile;
  double cellFreeLayer = 0.0;  ///< minimum distance between red cells and the wall [µm]
  bool capOpenings = true;     ///< close flat openings of the mesh of a vessel
  std::optional<bool> periodicEnds;
  std::optional<std::string> walls;     ///< axes that end in walls, as sorted letters
  std::optional<std::string> preInlet;  ///< direction of HemoCell's pre-inlet, "Xpos"
  std::optional<NodePlane> preInletSlice;
  std::vector<NodeRange> preInletRanges;  ///< part of that plane that is the inlet; one per axis
  bool keepAll = false;
  bool checkBox = false;       ///< `check --box`
  double dx = 0.5;             ///< lattice spacing [µm]; a case has it in its XML
  std::vector<double> alsoDx;  ///< other lattice spacings at which HemoCell is to keep the cells [µm]
  std::array<int, 3> tiles = {1, 1, 1};
  bool isTiled() const { return tiles != std::array<int, 3>{1, 1, 1}; }

  // Method
  Method::Kind method = Method::relaxation;
  CatSettings cat;                                 ///< of Method::cat; without a reserve
  std::optional<double> clearance, wallClearance;  ///< [µm]; empty: as large as possible at little cost
  bool largestClearance = false;                   ///< maximise the gap between membranes
  std::uint64_t seed = 1;
  bool rotate = true;
  bool inColumns = false;  ///< the species with the largest volume starts in columns
  Deforming deforming = Deforming::no;
  double maxForce = 10.0;              ///< on a vertex of a deformed cell [pN]
  double maxVolumeChange = 0.05;       ///< of a deformed cell [fraction]
  double maxAreaChange = 0.15;         ///< of a deformed cell [fraction]
  std::optional<double> ignoredScale;  ///< value of packCells' --scale

  // Limits, and what is done
  double maxSeconds = 0.0;                    ///< 0: no limit
  std::optional<std::int64_t> maxIterations;  ///< empty: default of the method
  std::optional<std::int64_t> threads;        ///< of each rank; empty: makeThreads() decides
  bool bestEffort = false;
  bool dryRun = false, validate = false;  ///< print what would be done; only check the input
  std::int64_t realisations = 1;
  std::optional<std::filesystem::path> restart;
  bool quiet = false, verbose = false;
  OutputRequest output;

  Origins origins;                       ///< of all that is stated
  std::vector<std::string> remarks;      ///< how words were understood, for the user
  std::vector<std::string> words;        ///< the command as it was typed, for reports; empty: wordsOf()
  std::shared_ptr<const Request> asked;  ///< of a completed request: as its front end made it, for states

  /// The origin of a value, or of the first of those within it ("container"); nullptr if none is stated.
  const Origin* originOf(const std::string& key) const;
  bool states(const std::string& key) const { return originOf(key) != nullptr; }
  bool hasLumen() const { return config || boxSize || container; }

  /// Least gaps, 0 where none is stated.
  Clearances demanded() const { return {clearance.value_or(0.0), wallClearance.value_or(0.0)}; }
  /// Not specified, so that packing may keep more than demanded (plan.h).
  bool choosesClearance() const { return !clearance && !largestClearance; }
  bool choosesWallClearance() const { return !wallClearance; }
  bool deforms() const { return deforming != Deforming::no; }
};

/// Platelets per red cell that packCells adds to a hematocrit.
constexpr double packCellsPlateletRatio = 0.07;

/// packCells' convention: a red cell has 97 µm³.
constexpr double packCellsRedCellVolume = 97.0;

/// Instead of a file: the profile of developed flow (plan_profile.h).
inline constexpr const char* developedProfile = "developed";

/// Names of the export formats.
inline constexpr const char* exportFormats[] = {
    "csv", "espresso", "espresso-membranes", "extxyz", "gsd", "lammps", "lammps-molecular", "mirheo", "npfem",
    "stl", "vtk",      "vtk-meshes"};

/// A larger number of species is probably an error.
constexpr std::size_t mostSpecies = 10'000;

/// The request for the species `name`, added if there is none yet. @throws InputError if there are too many
SpeciesRequest& speciesNamed(Request& request, const std::string& name);

/// The request for the species `name`, nullptr if there is none.
const SpeciesRequest* findSpecies(const Request& request, const std::string& name);

/// "species.RBC.count"
std::string keyOfSpecies(const std::string& name, const std::string& attribute);

}  // namespace packmesh::hemocell
