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
#include "hemocell_adapter/hemocell/hemocell_limits.h"
#include "hemocell_adapter/problem/counts.h"
#include "hemocell_adapter/problem/densest_known.h"
#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/problem/parts.h"
#include "packMesh/core/error.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/packing/single_cell.h"

namespace packmesh::hemocell {
namespace {

std::shared_ptr<const Shape> shapeOf(const JobSpecies& species, double dx,
                                     std::vector<std::string>& warnings) {
  try {
    switch (species.kind) {
      case JobSpecies::Template::model:
        return makeShape(species.model, dx, &warnings);
      case JobSpecies::Template::mesh:
        return makeShapeFromFile(species.meshFile, species.meshScale, species.meshFrame, dx, warnings);
      case JobSpecies::Template::ellipsoid:
        return makeEllipsoid(species.ellipsoidAxes.x(), species.ellipsoidAxes.y(), species.ellipsoidAxes.z());
    }
  } catch (const InputError& error) {
    throw InputError(fmt::format("cell '{}': {}", species.name, error.what()));
  }
  return nullptr;
}

/// Everything that decides a shape, but dx.
std::string keyOf(const JobSpecies& s) {
  const CellModel& m = s.model;
  return fmt::format("{} {} {} {} {} {} {} '{}' {} '{}'", int(s.meshFrame), int(s.kind), int(m.construction),
                     m.radius, m.minNumTriangles, m.aspectRatio, fmt::join(s.ellipsoidAxes, " "),
                     m.stlFile.string(), s.meshScale, s.meshFile.string());
}

/// A cell that cannot be in the lumen in any orientation: a ball inside it is wider than the lumen along an
/// axis, or it is longer than the diagonal. What takes longer to see is for pack() to refuse.
void refuseTooLarge(const Job& job, const SceneSpecies& species, const Container& container) {
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
    if (job.validate)  // pack() asks, too
      requireFitsAlone(species.job.name, *species.shape, container, wallClearanceOf(job, species.job),
                       job.clearance);
    return;
  }
  throw InputError(fmt::format(
      "cell '{}' is {:.4g} x {:.4g} x {:.4g} µm, larger than the lumen ({:.4g} x {:.4g} x {:.4g} µm)",
      species.job.name, cell[0], cell[1], cell[2], room[0], room[1], room[2]));
}

/// Cells that start in one place cannot be told from each other, and have as many pairs as the square of
/// their number: hardly positions in µm.
void refuseHeapedStart(const JobSpecies& species, const Shape& shape) {
  constexpr std::int64_t leastPairs = 1000, pairsPerCell = 4;
  const double edge = 0.5 * boundingBox(shape.mesh()).size().minCoeff();  // of cubes with one cell or few
  std::map<std::array<double, 3>, std::int64_t> cells;
  std::int64_t pairs = 0;
  for (const PosLine& line : species.start) {
    const Vec3 cube = (line.position / edge).array().floor();
    pairs += cells[{cube.x(), cube.y(), cube.z()}]++;
  }
  const auto count = static_cast<std::int64_t>(species.start.size());
  if (pairs > std::max(leastPairs, pairsPerCell * count))
    throw InputError(
        fmt::format("{}: too many of its {} cells are in one place (at least {} pairs nearer than {:.2g} µm) "
                    "to start from; are positions in µm?",
                    species.startFrom, count, pairs, std::sqrt(3.0) * edge));
}

/// HemoCell would delete every cell of this kind, wherever it is.
void refuseWithoutNode(const SceneSpecies& species) {
  if (!species.acceptance || species.acceptance->allowedNodes().fluidNodes() > 0) return;
  throw InputError(
      fmt::format("cell '{}': no node of the lattice is further than {} µm from all solid nodes, "
                  "so HemoCell would delete every such cell",
                  species.job.name, species.job.minimumDistanceFromSolid));
}

void resolveCounts(const Job& job, Scene& scene) {
  std::vector<CountedSpecies> counted;
  for (const SceneSpecies& species : scene.species) {
    CountedSpecies c;
    c.name = species.job.name;
    c.volume = species.shape->volume();
    c.redCell = species.job.redCell;
    c.count = species.job.count;
    c.ratio = species.job.ratio;
    if (c.redCell && job.redCellVolume) c.volume = *job.redCellVolume;
    // packCells' hematocrit knows nothing of the red cells that other options ask for.
    if (job.asPackCells && c.count) c.redCell = false;
    counted.push_back(c);
  }
  double reference = scene.referenceVolume(job);
  if (job.asPackCells && job.boxSize) reference = job.boxSize->prod();
  std::optional<double> hematocrit = job.hematocrit;
  if (!scene.regions.empty()) {
    *hematocrit = 0.0;
    for (const SceneRegion& region : scene.regions) *hematocrit += region.share * region.hematocrit;
  }
  const std::vector<std::int64_t> counts = countCells(counted, hematocrit, reference);
  double volume = 0.0;
  std::set<const Acceptance*> examined;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    scene.species[i].count = counts[i];
    volume += double(counts[i]) * scene.species[i].shape->volume();
    if (scene.species[i].mostCells() == 0) continue;
    refuseTooLarge(job, scene.species[i], *scene.lumen.container);
    if (examined.insert(scene.species[i].acceptance.get()).second) refuseWithoutNode(scene.species[i]);
  }
  const double lumen = scene.lumen.container->volume();
  if (volume >= lumen) {
    throw InputError(fmt::format("the cells asked for have a volume of {:.6g} µm³, the lumen only {:.6g} µm³",
                                 volume, lumen));
  }
  if (!job.bestEffort) refuseBeyondKnown(scene);
  if (volume > Forecast::possible * lumen && !job.inColumns) {
    scene.warnings.push_back(fmt::format(
        "the cells asked for fill {:.4f} of the lumen: above {:.2f} hardly any red cells were ever packed at "
        "random; --max-time and --best-effort bound the time it takes{}",
        volume / lumen, Forecast::possible, columnsInstead(job, scene)));
  }
}

}  // namespace

std::vector<std::string> limitWarnings(const Job& job, const Scene& scene,
                                       const std::vector<std::int64_t>& counts) {
  std::vector<std::string> warnings;
  std::int64_t cells = 0;
  for (std::size_t s = 0; s < scene.species.size(); ++s) {
    cells += counts[s];
    if (counts[s] == 0 || !job.config) continue;
    const SceneSpecies& species = scene.species[s];
    if (auto warning = envelopeWarning(species.job.name, species.shape->mesh(), job.config->domain))
      warnings.push_back(std::move(*warning));
  }
  if (auto warning = cellNumberWarning(cells, job.source.periodicity))
    warnings.push_back(std::move(*warning));
  return warnings;
}

namespace {

/// Shapes, counts and walls of a scene that has its lumen.
void complete(const Job& job, Scene& scene) {
  // Species that look alike share what is made for them.
  std::map<std::string, std::shared_ptr<const Shape>> shapes;
  std::map<int, std::shared_ptr<const Acceptance>> acceptances;  // by distance from solid
  for (const JobSpecies& jobSpecies : job.species) {
    SceneSpecies species;
    species.job = jobSpecies;
    std::shared_ptr<const Shape>& shape = shapes[keyOf(jobSpecies)];
    if (!shape) shape = shapeOf(jobSpecies, job.dx, scene.warnings);
    species.shape = shape;
    refuseHeapedStart(jobSpecies, *shape);
    if (scene.lumen.lattice) {
      const int distance = jobSpecies.minimumDistanceFromSolid;
      std::shared_ptr<const Acceptance>& acceptance = acceptances[distance];
      if (!acceptance) acceptance = std::make_shared<Acceptance>(scene.lumen.lattice, distance);
      species.acceptance = acceptance;
    }
    scene.species.push_back(std::move(species));
  }
  if (job.command == Command::check) return;
  if (!job.regions.empty() && !job.hematocrit)
    throw InputError(job.regions.front().body.where +
                     ": a region needs a hematocrit of the rest, if only 0.001");
  if (!job.autoWallClearance && job.wallClearance > 0.0 && !scene.lumen.container->wall())
    scene.warnings.push_back(
        "the clearance to the wall has no effect: the lumen is periodic and has no wall");
  if (job.cellFreeLayer > 0.0 && !(scene.lumen.container->wall() && scene.lumen.solidWalls))
    throw InputError("a cell-free layer is kept at walls, and this lumen has none (--walls makes some)");
  scene.regions = makeRegions(job, scene.lumen);
  resolveCounts(job, scene);
  std::vector<std::int64_t> counts;
  std::int64_t tiles = 1;
  if (job.dryRun)
    for (const int n : job.tiles) tiles *= n;
  for (const SceneSpecies& species : scene.species)
    // The larger box of --tile is a scene of its own; a dry run makes none.
    counts.push_back(species.mostCells() * tiles);
  for (std::string& warning : limitWarnings(job, scene, counts)) scene.warnings.push_back(std::move(warning));
  for (const JobSpecies& species : job.species)
    for (const auto* lines : {&species.fixed, &species.start})
      for (const PosLine& line : *lines) scene.read.add(line);
  setClearances(job, scene);
  for (std::string& warning : examineRegions(job, scene)) scene.warnings.push_back(std::move(warning));
}

}  // namespace

Scene buildScene(const Job& job) {
  Scene scene;
  scene.lumen = makeLumen(job);
  try {
    complete(job, scene);
  } catch (const InputError&) {
    for (const auto* list : {&scene.warnings, &scene.lumen.notices})  // may say why
      for (const std::string& warning : *list) log::warning(warning);
    throw;
  }
  return scene;
}

void setClearances(const Job& job, Scene& scene) {
  scene.parts = makeParts(job, scene);
  double reach = 0.0;
  for (const SceneSpecies& species : scene.species) reach = std::max(reach, 2 * species.shape->radius());
  std::map<std::pair<int, double>, std::shared_ptr<const Wall>>
      walls;  // by distance from solid and clearance
  for (SceneSpecies& species : scene.species) {
    if (species.mostCells() == 0) continue;
    const int distance = species.job.minimumDistanceFromSolid;
    const double clearance = wallClearanceOf(job, species.job);
    auto [wall, isNew] = walls.try_emplace({distance, clearance});
    // Relaxation demands the clearance plus a margin and is content when that margin is missed by its
    // tolerance; of the voxel faces nothing more is wanted then than that no vertex is beyond them.
    constexpr double margin = tolerance::relaxationMargin - tolerance::relaxationTolerance;
    if (isNew) wall->second = speciesWall(scene.lumen, distance, reach, clearance + margin);
    species.wall = wall->second;
  }
}

PackingProblem problemOf(const Job& job, const Scene& scene, std::function<bool()> interrupted,
                         std::function<void(const Progress&)> progress) {
  PackingProblem problem;
  double redCells = 0.0;
  for (const SceneSpecies& species : scene.species)
    if (species.job.redCell) redCells += double(species.count);
  for (const ScenePart& part : scene.parts) {
    const SceneSpecies& species = scene.species[part.species];
    problem.species.push_back(
        {part.name, species.shape, part.count, species.wall, species.job.redCell, part.start, part.freedom});
    if (species.job.ratio && part.count == species.count)
      problem.species.back().asked = *species.job.ratio * redCells;
  }
  problem.container = scene.lumen.container;
  problem.method = job.method;
  problem.planeSource = job.planeSource;
  problem.growth = job.growth;
  if (job.escape) {
    problem.escape.emplace();
    for (const ScenePart& part : scene.parts)
      problem.escape->reserve.push_back(scene.species[part.species].job.stock);
  }
  problem.clearance = job.clearance;
  problem.wallClearance = job.wallClearance;
  problem.seed = job.seed;
  problem.rotate = job.rotate;
  if (job.inColumns) {
    const auto volume = [](const Species& s) { return double(s.count) * s.shape->volume(); };
    const auto most =
        std::max_element(problem.species.begin(), problem.species.end(),
                         [&](const Species& a, const Species& b) { return volume(a) < volume(b); });
    if (most != problem.species.end() && most->count > 0) most->inColumns = true;
  }
  problem.limits.maxSeconds = job.maxSeconds;
  if (job.maxIterations) problem.limits.maxSweeps = *job.maxIterations;
  problem.written = [&scene](const Pose& pose) { return placementOf(scene.read.lineOf(pose)); };
  problem.interrupted = std::move(interrupted);
  problem.progress = std::move(progress);
  return problem;
}

}  // namespace packmesh::hemocell
