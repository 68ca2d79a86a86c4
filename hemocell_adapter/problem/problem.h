// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What is to be packed or examined, and queries about it: a scene has the lumen and the kinds of
/// cells, a problem also their numbers and where they are. Both are made by make_problem.h, and are not
/// changed.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/hemocell/case.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/hemocell/pre_inlet.h"
#include "hemocell_adapter/problem/cell_species.h"
#include "hemocell_adapter/problem/depth_profile.h"
#include "hemocell_adapter/problem/lumen.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/certificate/certificate.h"
#include "packMesh/core/input_file.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"

namespace packmesh::hemocell {

/// How something was built, for the user.
struct Notices {
  std::vector<std::string> warnings;
  std::vector<std::string> repairs;  ///< of meshes

  void append(const Notices& later);
};

/// A lumen and the kinds of cells that are for it, with their shapes and the cells that exist already.
struct Scene {
  Request request;                           ///< complete: nothing is left open
  std::shared_ptr<const Case> simulation;    ///< nullptr: there is no case
  std::optional<PreInletPlace> preInlet;     ///< of a case whose pre-inlet is packed
  Communicator ranks;                        ///< that work on it
  Threads team;                              ///< of this rank
  std::shared_ptr<const InputFiles> inputs;  ///< that were read for it
  Lumen lumen;
  Clearances demanded;  ///< least gaps [µm]
  std::vector<CellSpecies> species;
  /// Templates of the species, in their order, then the meshes of deformed cells.
  Shapes shapes;

  /// The running system of the case; nullptr outside of HemoCell.
  const RunningSystem* running() const {
    return simulation && simulation->running ? &*simulation->running : nullptr;
  }

  /// Whether there may be cells with meshes of their own, and whether a cell has one.
  bool hasDeformed() const { return shapes.size() > species.size(); }
  bool isDeformed(const PlacedCell& cell) const { return cell.shape != cell.species; }
  /// The shape of an existing cell, and the cell where it is.
  static int shapeOf(const PresentCell& cell) { return cell.shape < 0 ? cell.species : cell.shape; }
  static PlacedCell placed(const PresentCell& cell) {
    return {cell.species, shapeOf(cell), placementOf(cell)};
  }

  /// Cells of a packing, at most.
  std::int64_t mostCells() const {
    std::int64_t cells = 0;
    for (const CellSpecies& one : species) cells += one.mostCells();
    return cells;
  }

  /// The volume to which the hematocrit refers [µm³].
  double referenceVolume() const {
    return request.fluidVolume ? lumen.fluidVolume() : lumen.container->volume();
  }
};

/// Where in a lumen cells are to be.
struct Layout {
  std::vector<LumenRegion> regions;  ///< empty: one hematocrit for all of it; else the last is the rest
  std::shared_ptr<const DepthProfile> profile;  ///< nullptr: cells may be at any depth

  /// Whether red cells are divided among the regions; false: they may be anywhere.
  bool dividesRedCells() const {
    return std::any_of(regions.begin(), regions.end(), [](const LumenRegion& region) { return region.own; });
  }
};

/// Cells of one species with the same constraints, which form a species of the problem that is packed.
struct Part {
  int species = 0;
  int region = -1;  ///< in Layout::regions, or shell of a profile; -1: none
  Species cells;    ///< "RBC", "RBC, fixed", "RBC, region 1"; its shapes are Scene::shapes
};

/// What is packed with these clearances. Made by partsAt() (parts.h).
struct PartsToPack {
  Clearances clearances;
  std::vector<std::shared_ptr<const Wall>> walls;  ///< of each species; nullptr: the container's own
  std::vector<Part> parts;
};

/// A scene whose cells have been counted and divided into parts, or are to be examined.
struct Problem : Scene {
  /// In the lumen: as requested, or as it follows from the discharge hematocrit; empty: numbers are
  /// requested.
  std::optional<double> hematocrit;
  Layout layout;
  PartsToPack atDemanded;  ///< what is packed with the clearances demanded; empty for a check
  std::shared_ptr<const ReadLines> read = std::make_shared<const ReadLines>();  ///< existing cells
  Notices notices;
  std::filesystem::path posFolder;     ///< of a check: of the .pos files
  std::vector<std::string> unchecked;  ///< .pos files that a check cannot examine
};

/// Hints for requests beyond random packing: "; --order columns ...", if columns (see Columns) are possible
/// for that problem, and those of deformedInstead().
std::string denserInstead(const Scene& scene);
/// "; --soft ...", or empty if cells are soft already or cannot be.
std::string deformedInstead(const Scene& scene);

/// The species as the user states them, all their cells together, with the clearances demanded: to examine
/// and measure cells, not to pack them.
Physics physicsOf(const Scene& scene);

/// How cells come into HemoCell. Its loader of .pos files deletes those that cross a periodic face; the
/// plug-in adds them, and also deformed cells that are nearer to a wall than the loader would accept.
enum class Loading { posFiles, plugIn };

/// How cells of a packing are loaded: if some have meshes of their own, by the plug-in. All ranks call.
/// @param own of this rank
Loading loadingOf(const Scene& scene, const std::vector<PlacedCell>& own);

/// Why HemoCell deletes a cell whose one fault is to cross a periodic face. This is as expected; every other
/// reason is a fault.
inline constexpr const char* crossesFace = "crosses a periodic face";
inline bool isExpected(const std::string& reason) {
  return reason == crossesFace;
}

/// HemoCell's verdict on a placed cell: nothing if it keeps the cell, otherwise the reason why not.
std::optional<std::string> hemocellViolation(const Scene& scene, const PlacedCell& cell, Loading loading);
/// Calls visit(cell, violation) for each cell, in order, in the calling thread.
void forEachVerdict(
    const Scene& scene, const std::vector<PlacedCell>& cells, Loading loading,
    const std::function<void(std::size_t cell, const std::optional<std::string>& violation)>& visit);

/// Axes along which the lumen of a scene ends other than at a wall.
std::array<bool, 3> endAxes(const Scene& scene);

/// Whether it is known which cells HemoCell keeps: there is a lattice, or a box.
bool knowsAcceptance(const Scene& scene);

/// Volumes and numbers of a set of cells.
struct Tally {
  std::vector<std::int64_t> counts;  ///< per species
  std::vector<double> meshVolume;    ///< per species [µm³]
  double redMesh = 0.0;              ///< volume of the red cells' meshes [µm³]
  double redHemocell = 0.0;          ///< the same by `<Volume>`, where given [µm³]
  bool hemocellKnown = true;         ///< every red species present has a `<Volume>`
  std::int64_t redCells = 0;
};

/// The number of cells of each species.
std::vector<std::int64_t> countsOf(const Scene& scene, const std::vector<PlacedCell>& cells);

/// The number of deformed cells of each species on all ranks. All ranks call. @param own of this rank
std::vector<std::int64_t> deformedCounts(const Scene& scene, const std::vector<PlacedCell>& own);

/// By how much the volumes of deformed cells exceed those of their templates: per species, on all ranks
/// [µm³]. The sums do not depend on the number of ranks. All ranks call.
/// @param own of this rank
/// @param counts whether a cell counts; empty: all do
std::vector<double> excessVolumes(const Scene& scene, const std::vector<PlacedCell>& own,
                                  const std::function<bool(std::size_t cell)>& counts = {});

/// @param counts of the species
/// @param excess of these cells, see excessVolumes()
Tally tallyOf(const Scene& scene, std::vector<std::int64_t> counts, const std::vector<double>& excess);

}  // namespace packmesh::hemocell
