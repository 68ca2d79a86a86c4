// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/build_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/hemocell_limits.h"
#include "hemocell_adapter/problem/counts.h"
#include "hemocell_adapter/problem/densest_known.h"
#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/problem/make_lumen.h"
#include "hemocell_adapter/problem/parts.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_record.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/packing/single_cell.h"

namespace packmesh::hemocell {
namespace {

std::shared_ptr<const Shape> shapeOf(const CellSpecies& species, double dx, const Threads& threads,
                                     std::vector<std::string>& warnings) {
  try {
    switch (species.kind) {
      case CellSpecies::Template::model:
        return makeShape(species.model, dx, &warnings, threads);
      case CellSpecies::Template::mesh:
        return makeShapeFromFile(species.meshFile, species.meshScale, species.meshFrame, dx, warnings,
                                 threads);
      case CellSpecies::Template::built:
        return makeShapeOfBuilt(species.builtMesh, species.name, dx, threads);
      case CellSpecies::Template::ellipsoid:
        return makeEllipsoid(species.ellipsoidAxes.x(), species.ellipsoidAxes.y(), species.ellipsoidAxes.z());
    }
  } catch (const InputError& error) {
    throw InputError(fmt::format("cell '{}': {}", species.name, error.what()));
  }
  return nullptr;
}

/// Everything that determines a shape, except dx.
std::string keyOf(const CellSpecies& s) {
  const CellModel& m = s.model;
  if (s.kind == CellSpecies::Template::built) return s.name;
  return fmt::format("{} {} {} {} {} {} {} '{}' {} '{}'", int(s.meshFrame), int(s.kind), int(m.construction),
                     m.radius, m.minNumTriangles, m.aspectRatio, fmt::join(s.ellipsoidAxes, " "),
                     m.stlFile.string(), s.meshScale, s.meshFile.string());
}

/// Refuses a cell that cannot be in the lumen in any orientation: a ball inside it is wider than the lumen
/// along an axis, or it is longer than the diagonal. Cases that take longer to detect are refused by pack().
void refuseTooLarge(const Scene& scene, const CellSpecies& species) {
  const Container& container = *scene.lumen.container;
  const Vec3 cell = boundingBox(species.shape->mesh()).size();
  const Vec3 room = container.bounds().size();
  constexpr double surely = 0.98;  // depths inside meshes are interpolated
  const double ball = 2.0 * surely * species.shape->halfThickness();
  bool fits = true, endless = false;
  for (int k = 0; k < 3; ++k) {
    const bool periodic = container.period()[k] > 0.0;
    endless = endless || periodic;
    fits = fits && (periodic || ball < room[k]);
  }
  if (fits && (endless || cell.maxCoeff() < room.norm())) {
    if (scene.validate)  // pack() tests it, too
      requireFitsAlone(species.name, *species.shape, container, species.wallClearance(scene.demanded.wall),
                       scene.demanded.membranes);
    return;
  }
  throw InputError(fmt::format(
      "cell '{}' is {:.4g} x {:.4g} x {:.4g} µm, larger than the lumen ({:.4g} x {:.4g} x {:.4g} µm)",
      species.name, cell[0], cell[1], cell[2], room[0], room[1], room[2]));
}

/// Cells that start at the same position cannot be separated, and have a quadratic number of pairs: probably
/// positions that are not in µm.
void refuseHeapedStart(const CellSpecies& species) {
  constexpr std::int64_t leastPairs = 1000, pairsPerCell = 4;
  const double edge =
      0.5 * boundingBox(species.shape->mesh()).size().minCoeff();  // of cubes with one cell or few
  std::map<std::array<double, 3>, std::int64_t> cells;
  std::int64_t pairs = 0;
  for (const PosLine& line : species.start) {
    const Vec3 cube = (line.position / edge).array().floor();
    pairs += cells[{cube.x(), cube.y(), cube.z()}]++;
  }
  const auto count = static_cast<std::int64_t>(species.start.size());
  if (pairs > std::max(leastPairs, pairsPerCell * count))
    throw InputError(
        fmt::format("{}: too many of its {} cells coincide (at least {} pairs nearer than {:.2g} µm) "
                    "to start from; are positions in µm?",
                    species.startFrom, count, pairs, std::sqrt(3.0) * edge));
}

/// Refuses a kind of cell of which HemoCell would delete every one, wherever it is.
void refuseWithoutNode(const CellSpecies& species) {
  if (!species.acceptance || species.acceptance->allowedNodes().hasFluidNodes()) return;
  throw InputError(
      fmt::format("cell '{}': no node of the lattice is further than {} µm from all solid nodes, "
                  "so HemoCell would delete every such cell",
                  species.name, species.minimumDistanceFromSolid));
}

void resolveCounts(Scene& scene) {
  double reference = scene.referenceVolume();
  if (scene.asPackCells && scene.boxSize) reference = scene.boxSize->prod();
  std::optional<double> hematocrit = scene.hematocrit;
  if (!scene.lumen.regions.empty()) {
    *hematocrit = 0.0;
    for (const LumenRegion& region : scene.lumen.regions) *hematocrit += region.share * region.hematocrit;
  }
  const std::vector<std::int64_t> counts = countCells(scene.species, hematocrit, reference);
  double volume = 0.0;
  std::set<const Acceptance*> examined;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    CellSpecies& species = scene.species[i];
    species.count = counts[i];
    volume += double(counts[i]) * species.shape->volume();
    if (species.mostCells() == 0) continue;
    refuseTooLarge(scene, species);
    if (examined.insert(species.acceptance.get()).second) refuseWithoutNode(species);
  }
  const double lumen = scene.lumen.container->volume();
  if (volume >= lumen) {
    throw InputError(fmt::format("the requested cells have a volume of {:.6g} µm³, the lumen only {:.6g} µm³",
                                 volume, lumen));
  }
  if (!scene.bestEffort) refuseBeyondKnown(scene);
  if (volume > Forecast::possible * lumen && !scene.inColumns) {
    scene.notices.push_back(
        fmt::format("the requested cells fill {:.4f} of the lumen: above {:.2f} no random packing of red "
                    "cells is known; --max-time and --best-effort limit the run time{}",
                    volume / lumen, Forecast::possible, columnsInstead(scene)));
  }
}

}  // namespace

std::vector<std::string> limitWarnings(const Scene& scene, const std::vector<std::int64_t>& counts) {
  std::vector<std::string> warnings;
  std::int64_t cells = 0;
  std::string longestCell;
  double longest = 0.0;
  for (std::size_t s = 0; s < scene.species.size(); ++s) {
    cells += counts[s];
    if (counts[s] == 0 || !scene.config) continue;
    const double length = longestExtent(scene.species[s].shape->mesh());
    if (length <= longest) continue;
    longest = length;
    longestCell = scene.species[s].name;
  }
  std::optional<std::array<int, 3>> nodes;
  if (scene.lumen.lattice) nodes = scene.lumen.lattice->nodes();
  if (longest > 0.0)
    if (auto warning = envelopeWarning(longestCell, longest, scene.config->domain, nodes))
      warnings.push_back(std::move(*warning));
  if (auto warning = cellNumberWarning(cells, scene.source.periodicity))
    warnings.push_back(std::move(*warning));
  return warnings;
}

namespace {

/// Shapes of a scene that has its lumen, and HemoCell's acceptance of them.
void buildSpecies(Scene& scene) {
  // Species with equal shapes share their data.
  std::map<std::string, std::shared_ptr<const Shape>> shapes;
  std::map<int, std::shared_ptr<const Acceptance>> acceptances;  // by distance from solid
  for (CellSpecies& species : scene.species) {
    std::shared_ptr<const Shape>& shape = shapes[keyOf(species)];
    if (!shape) shape = shapeOf(species, scene.dx, scene.team, scene.notices);
    species.shape = shape;
    species.countedVolume = shape->volume();
    if (species.redCell && scene.redCellVolume) species.countedVolume = *scene.redCellVolume;
    refuseHeapedStart(species);
    if (scene.lumen.lattice) {
      const int distance = species.minimumDistanceFromSolid;
      std::shared_ptr<const Acceptance>& acceptance = acceptances[distance];
      if (!acceptance) acceptance = std::make_shared<Acceptance>(scene.lumen.lattice, distance);
      species.acceptance = acceptance;
    }
  }
}

/// Clearances and layers for which this lumen has no wall.
void examineWall(Scene& scene) {
  const bool wall = scene.lumen.container->wall();
  if (!scene.autoWallClearance && scene.demanded.wall > 0.0 && !wall)
    scene.notices.push_back("the clearance to the wall has no effect: the lumen is periodic and has no wall");
  if (scene.cellFreeLayer > 0.0 && !(wall && scene.lumen.solidWalls))
    throw InputError("a cell-free layer requires walls, and this lumen has none (see --walls)");
}

/// Regions, counts, parts and walls of a scene that has its lumen and its shapes.
void preparePacking(Scene& scene) {
  if (!scene.regions.empty() && !scene.hematocrit)
    throw InputError(scene.regions.front().body.where +
                     ": regions require a hematocrit of the rest of the lumen, for example 0.001");
  examineWall(scene);
  scene.lumen.regions = makeRegions(scene, scene.lumen);
  resolveCounts(scene);
  std::vector<std::int64_t> counts;
  std::int64_t tiles = 1;
  if (scene.dryRun)
    for (const int n : scene.tiles) tiles *= n;
  for (const CellSpecies& species : scene.species)
    // The larger box of --tile is a separate scene; a dry run creates none.
    counts.push_back(species.mostCells() * tiles);
  for (std::string& warning : limitWarnings(scene, counts)) scene.notices.push_back(std::move(warning));
  for (const CellSpecies& species : scene.species)
    for (const auto* lines : {&species.fixed, &species.start})
      for (const PosLine& line : *lines) scene.read.add(line);
  setClearances(scene, scene.demanded);
  for (std::string& warning : examineRegions(scene)) scene.notices.push_back(std::move(warning));
}

}  // namespace

Scene buildScene(Job job, const Communicator& ranks) {
  Scene scene(std::move(job));
  scene.ranks = ranks;
  scene.team = teamOf(scene.threads, ranks);
  scene.inputs = recordedInputs();
  scene.lumen = makeLumen(scene);
  const auto takeNotices = [&] {
    for (std::string& notice : scene.lumen.notices) scene.notices.push_back(std::move(notice));
  };
  try {
    buildSpecies(scene);
    if (scene.command != Command::check) preparePacking(scene);
  } catch (const InputError&) {
    takeNotices();
    for (const std::string& notice : scene.notices) log::warning(notice);  // may explain the failure
    throw;
  }
  takeNotices();
  return scene;
}

void setClearances(Scene& scene, const Clearances& clearances) {
  scene.clearances = clearances;
  double reach = 0.0;
  for (const CellSpecies& species : scene.species) reach = std::max(reach, 2 * species.shape->radius());
  std::map<std::pair<int, double>, std::shared_ptr<const Wall>>
      walls;  // by distance from solid and clearance
  for (CellSpecies& species : scene.species) {
    if (species.mostCells() == 0) continue;
    const int distance = species.minimumDistanceFromSolid;
    const double clearance = species.wallClearance(clearances.wall);
    auto [wall, isNew] = walls.try_emplace({distance, clearance});
    // Relaxation aims at the clearance plus a margin and stops within its tolerance of that; for the voxel
    // faces it then suffices that no vertex is beyond them.
    constexpr double margin = tolerance::relaxationMargin - tolerance::relaxationTolerance;
    if (isNew) wall->second = speciesWall(scene.lumen, distance, reach, clearance + margin);
    species.wall = wall->second;
  }
  scene.parts = makeParts(scene);
}

PackingProblem problemOf(const Scene& scene, std::function<bool()> interrupted,
                         std::function<void(const Progress&)> progress) {
  PackingProblem problem;
  double redCells = 0.0;
  for (const CellSpecies& species : scene.species)
    if (species.redCell) redCells += double(species.count);
  for (const ScenePart& part : scene.parts) {
    const CellSpecies& species = scene.species[part.species];
    problem.species.push_back(part.cells);
    if (species.ratio && part.cells.count == species.count)
      problem.species.back().asked = *species.ratio * redCells;
  }
  problem.container = scene.lumen.container;
  problem.communicator = scene.ranks;
  problem.threads = scene.team;
  problem.method = scene.method;
  problem.planeSource = scene.planeSource;
  problem.growth = scene.growth;
  if (scene.escape) {
    problem.escape.emplace();
    for (const ScenePart& part : scene.parts)
      problem.escape->reserve.push_back(scene.species[part.species].stock);
  }
  problem.clearance = scene.clearances.membranes;
  problem.wallClearance = scene.clearances.wall;
  problem.seed = scene.seed;
  problem.rotate = scene.rotate;
  if (scene.inColumns) {
    const auto volume = [](const Species& s) { return double(s.count) * s.shape->volume(); };
    const auto most =
        std::max_element(problem.species.begin(), problem.species.end(),
                         [&](const Species& a, const Species& b) { return volume(a) < volume(b); });
    if (most != problem.species.end() && most->count > 0) most->inColumns = true;
  }
  problem.limits.maxSeconds = scene.maxSeconds;
  if (scene.maxIterations) problem.limits.maxSweeps = *scene.maxIterations;
  problem.written = [&scene](const Pose& pose) { return placementOf(scene.read.lineOf(pose)); };
  problem.interrupted = std::move(interrupted);
  problem.progress = std::move(progress);
  return problem;
}

}  // namespace packmesh::hemocell
