// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/make_problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>
#include <set>
#include <utility>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/hemocell_limits.h"
#include "hemocell_adapter/problem/blood.h"
#include "hemocell_adapter/problem/completed_request.h"
#include "hemocell_adapter/problem/counts.h"
#include "hemocell_adapter/problem/depth_profile.h"
#include "hemocell_adapter/problem/make_lumen.h"
#include "hemocell_adapter/problem/make_species.h"
#include "hemocell_adapter/problem/other_spacings.h"
#include "hemocell_adapter/problem/parts.h"
#include "hemocell_adapter/problem/plan_profile.h"
#include "hemocell_adapter/problem/species_plans.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"

namespace packmesh::hemocell {

std::vector<std::string> limitWarnings(const Scene& scene, const std::vector<std::int64_t>& counts) {
  std::vector<std::string> warnings;
  std::int64_t cells = 0;
  std::string longestCell;
  double longest = 0.0;
  for (std::size_t s = 0; s < scene.species.size(); ++s) {
    cells += counts[s];
    if (counts[s] == 0 || !scene.simulation) continue;
    const double length = longestExtent(scene.species[s].shape->mesh());
    if (length <= longest) continue;
    longest = length;
    longestCell = scene.species[s].name;
  }
  std::optional<std::array<int, 3>> nodes;
  if (scene.lumen.lattice) nodes = scene.lumen.lattice->nodes();
  if (longest > 0.0)
    if (auto warning = envelopeWarning(longestCell, longest, scene.simulation->domain, nodes))
      warnings.push_back(std::move(*warning));
  const CaseSource noCode;
  const CaseSource& code = scene.simulation ? scene.simulation->source : noCode;
  if (auto warning = cellNumberWarning(cells, code.periodicity)) warnings.push_back(std::move(*warning));
  return warnings;
}

namespace {

/// What the user is told, also if a problem cannot be made.
struct Telling {
  Notices notices, ofLumen;  ///< those of the lumen are told last

  Notices all() const {
    Notices all = notices;
    all.append(ofLumen);
    return all;
  }
};

/// Calls make(telling), which makes a problem. If that fails, notices are logged: they may explain it.
template <class Make>
Problem madeTelling(const CompletedRequest& completed, const Make& make) {
  Telling telling;
  telling.notices.warnings = completed.warnings;
  try {
    Problem problem = make(telling);
    problem.notices = telling.all();
    return problem;
  } catch (...) {
    tell(telling.all());
    throw;
  }
}

/// @param demanded least gaps; empty: those of the request
Scene makeScene(const CompletedRequest& completed, const Communicator& ranks, std::vector<SpeciesPlan> plans,
                bool packs, const std::optional<Clearances>& demanded, Telling& telling) {
  Scene scene;
  scene.request = completed.request;
  scene.simulation = completed.simulation;
  scene.preInlet = completed.preInlet;
  scene.ranks = ranks;
  scene.team = makeThreads(scene.request.threads, ranks);
  scene.inputs = recordedInputs();
  const Case* const simulation = scene.simulation.get();
  Lumen lumen = makeLumen(scene.request, simulation, scene.preInlet);
  telling.ofLumen = {lumen.notices, lumen.repairs};
  if (auto warning = unseenWallWarning(lumen)) telling.ofLumen.warnings.push_back(std::move(*warning));
  scene.lumen = withOtherSpacings(std::move(lumen), scene.request, simulation, scene.preInlet);
  scene.demanded = demanded.value_or(scene.request.demanded());
  // Membranes may extend further at another spacing.
  scene.demanded.membranes =
      std::max(scene.demanded.membranes, 2.0 * inflationElsewhere(scene.lumen, scene.request.dx));
  SpeciesAndShapes made =
      makeSpecies(std::move(plans), scene.lumen, scene.request, scene.team, packs, telling.notices);
  scene.species = std::move(made.species);
  scene.shapes = std::move(made.shapes);
  return scene;
}

void refuseContradictions(const Request& request) {
  if (request.deforms()) refuseBesideDeforming(request);
  for (const RegionRequest& region : request.regions)
    if (region.hematocrit && !request.hematocrit)
      throw InputError(
          region.body.where +
          ": regions require a hematocrit of the rest of the lumen; 0: red cells in regions alone");
  if (request.regions.empty() && request.hematocrit && *request.hematocrit == 0.0)
    throw InputError(named("hematocrit", "0") + " asks for no red cells; use it with regions");
  if (request.profile && !request.regions.empty())
    throw InputError(request.regions.front().body.where + ": regions and a profile (" + named("profile") +
                     ", <profile>) exclude each other");
  if (request.profile && request.inColumns)
    throw InputError(named("order", "columns") + " (<order>) and a profile (" + named("profile") +
                     ", <profile>) exclude each other: both determine where the cells are");
}

/// Clearances and layers for which a lumen has no wall.
void examineWall(const Scene& scene, Notices& notices) {
  const Request& request = scene.request;
  const bool wall = scene.lumen.container->wall();
  if (!request.choosesWallClearance() && scene.demanded.wall > 0.0 && !wall)
    notices.warnings.emplace_back(
        "the clearance to the wall has no effect: the lumen is periodic and has no wall");
  if (request.cellFreeLayer > 0.0 && !(wall && scene.lumen.solidWalls))
    throw InputError("a cell-free layer requires walls, and this lumen has none (see " + named("walls") +
                     ")");
}

/// The hematocrit in the lumen.
std::optional<double> resolveHematocrit(const Scene& scene, Notices& notices) {
  if (!scene.request.dischargeHematocrit) return scene.request.hematocrit;
  const auto diameter =
      scene.lumen.solidWalls ? hydraulicDiameter(*scene.lumen.container, endAxes(scene)) : std::nullopt;
  if (!diameter)
    throw InputError(
        "a discharge hematocrit belongs to a lumen with walls that blood flows along; this one has none "
        "(see " +
        named("walls") + "). Give the hematocrit of the lumen instead");
  if (auto warning = fahraeusWarning(*diameter))
    notices.warnings.push_back("discharge hematocrit: " + *warning);
  return tubeHematocrit(*scene.request.dischargeHematocrit, *diameter);
}

/// A way to divide the cells of a scene into parts.
struct Division {
  std::vector<CellSpecies> species;  ///< with their numbers, and mean volumes of the cells that are placed
  Layout layout;
  PartsToPack parts;
  Notices ofProfile;
};

/// @param layout with the profile, if it is planned already
Division divided(const Scene& scene, const Layout& layout) {
  Division division{scene.species, layout, {}, {}};
  if (scene.request.profile && !layout.profile)
    division.layout.profile = planProfile(scene, division.ofProfile.warnings);
  division.parts = partsAt(scene, division.layout, scene.demanded);
  return division;
}

/// Of deformed cells: the numbers depend on the volumes of those that are placed, and these on the numbers.
/// The division whose numbers are nearest to those that its volumes ask for.
Division dividedByVolume(Scene scene, std::optional<double> hematocrit, const Layout& layout) {
  constexpr int mostRounds = 24;  // two or three are enough where all cells have similar volumes
  std::optional<Division> best;
  std::pair<std::int64_t, double> least;  // differences of its numbers, and of the volume of red cells
  std::set<std::vector<std::int64_t>> tried;
  std::vector<std::int64_t> counts = numbersOfCells(scene, hematocrit, layout.regions);
  for (int round = 0; round < mostRounds && (!best || least.first > 0); ++round) {
    tried.insert(counts);
    scene.species = withCounts(std::move(scene.species), counts);
    Division division = divided(scene, layout);
    scene.species = withMeanVolumes(std::move(scene.species), averagePlaced(scene, division.parts.parts),
                                    scene.request.redCellVolume);
    division.species = scene.species;
    const std::vector<std::int64_t> wanted = numbersOfCells(scene, hematocrit, layout.regions);
    std::pair<std::int64_t, double> misses(0, -hematocrit.value_or(0.0) * scene.referenceVolume());
    std::size_t most = 0;
    for (std::size_t s = 0; s < counts.size(); ++s) {
      misses.first += std::abs(wanted[s] - counts[s]);
      if (scene.species[s].sharesHematocrit)
        misses.second += double(counts[s]) * scene.species[s].countedVolume;
      if (std::abs(wanted[s] - counts[s]) > std::abs(wanted[most] - counts[most])) most = s;
    }
    misses.second = std::abs(misses.second);
    if (!best || misses < least) {
      best = std::move(division);
      least = misses;
    }
    // Numbers that alternate: those around them.
    counts = wanted;
    for (std::int64_t n = 1; tried.count(counts) > 0; ++n)
      counts[most] = std::max<std::int64_t>(0, wanted[most] + (n % 2 == 1 ? (n + 1) / 2 : -n / 2));
  }
  return std::move(*best);
}

/// Counts the cells of a scene and divides them into parts.
Problem divideIntoParts(Scene scene, std::optional<double> hematocrit, std::vector<LumenRegion> regions,
                        Notices& notices) {
  const bool deformed = scene.hasDeformed();
  scene.species =
      withMeanVolumes(std::move(scene.species), averagePresent(scene), scene.request.redCellVolume);
  if (!deformed) {
    scene.species = withCounts(std::move(scene.species), numbersOfCells(scene, hematocrit, regions));
    examineNumbers(scene, notices);
  }
  const Layout layout{std::move(regions), nullptr};
  Division division = deformed ? dividedByVolume(scene, hematocrit, layout) : divided(scene, layout);
  scene.species = std::move(division.species);
  if (deformed) examineNumbers(scene, notices);
  if (division.layout.profile && !scene.request.bestEffort && !scene.request.deforms())
    refuseTooDense(scene, *division.layout.profile);
  notices.append(division.ofProfile);
  Problem problem;
  static_cast<Scene&>(problem) = std::move(scene);
  problem.hematocrit = hematocrit;
  problem.layout = std::move(division.layout);
  problem.atDemanded = std::move(division.parts);
  return problem;
}

/// The numbers of cells that limits of HemoCell apply to. The larger box of --tile is a separate problem; a
/// dry run makes none.
std::vector<std::int64_t> countMostCells(const Scene& scene) {
  std::int64_t tiles = 1;
  if (scene.request.dryRun)
    for (const int n : scene.request.tiles) tiles *= n;
  std::vector<std::int64_t> counts;
  for (const CellSpecies& species : scene.species) counts.push_back(species.mostCells() * tiles);
  return counts;
}

/// Lines of the cells that exist already.
std::shared_ptr<const ReadLines> linesOfPresent(const std::vector<CellSpecies>& all) {
  auto read = std::make_shared<ReadLines>();
  for (const CellSpecies& species : all)
    for (const auto* lines : {&species.fixed, &species.start})
      for (const PosLine& line : *lines) read->add(line);
  return read;
}

/// The problem of packing the cells of a scene: regions, counts and parts.
Problem prepareToPack(Scene scene, Notices& notices) {
  refuseContradictions(scene.request);
  examineWall(scene, notices);
  const std::optional<double> hematocrit = resolveHematocrit(scene, notices);
  std::vector<LumenRegion> regions =
      makeRegions(scene.request, hematocrit, scene.lumen, scene.team, notices.repairs);
  Problem problem = divideIntoParts(std::move(scene), hematocrit, std::move(regions), notices);
  requireLinkedVertices(problem.species);
  if (problem.request.deforms()) requireMembranes(problem);
  problem.read = linesOfPresent(problem.species);
  const auto warn = [&](std::vector<std::string> warnings) { notices.append({std::move(warnings), {}}); };
  warn(limitWarnings(problem, countMostCells(problem)));
  warn(examineRegions(problem, problem.layout, problem.atDemanded.parts));
  return problem;
}

}  // namespace

void tell(const Notices& notices) {
  for (const std::string& warning : notices.warnings) log::warning(warning);
  for (const std::string& repair : notices.repairs) log::repair(repair);
}

Problem problemToPack(const CompletedRequest& completed, const Communicator& ranks) {
  return madeTelling(completed, [&](Telling& telling) {
    std::vector<std::string>& warnings = telling.notices.warnings;
    const Case* const simulation = completed.simulation.get();
    for (std::string& warning : unreadWalls(completed.request, simulation))
      warnings.push_back(std::move(warning));
    std::vector<SpeciesPlan> plans = plansToPack(completed.request, simulation, warnings);
    if (simulation) plans = withDistancesFromSolid(*simulation, std::move(plans), warnings);
    Scene scene = makeScene(completed, ranks, std::move(plans), true, {}, telling);
    return prepareToPack(withBlood(std::move(scene), telling.notices), telling.notices);
  });
}

Problem problemOfExistingCells(const CompletedRequest& completed, std::vector<SpeciesPlan> plans,
                               const Clearances& clearances, const Communicator& ranks) {
  return madeTelling(completed, [&](Telling& telling) {
    return prepareToPack(makeScene(completed, ranks, std::move(plans), false, clearances, telling),
                         telling.notices);
  });
}

Problem problemToCheck(const CompletedRequest& completed, const std::filesystem::path& folder,
                       const Communicator& ranks) {
  return madeTelling(completed, [&](Telling& telling) {
    std::vector<std::string>& warnings = telling.notices.warnings;
    const Case* const simulation = completed.simulation.get();
    for (std::string& warning : unreadWalls(completed.request, simulation))
      warnings.push_back(std::move(warning));
    CheckedSpecies found = plansToCheck(completed.request, simulation, folder, warnings);
    if (simulation) found.plans = withDistancesFromSolid(*simulation, std::move(found.plans), warnings);
    Problem problem;
    static_cast<Scene&>(problem) = makeScene(completed, ranks, std::move(found.plans), false, {}, telling);
    problem.hematocrit = completed.request.hematocrit;
    problem.posFolder = folder;
    problem.unchecked = std::move(found.unchecked);
    return problem;
  });
}

Problem withOtherCells(Problem problem, std::vector<SpeciesPlan> plans, const Clearances& clearances) {
  std::vector<std::int64_t> counts;
  for (const SpeciesPlan& plan : plans) counts.push_back(std::int64_t(plan.fixed.size() + plan.start.size()));
  SpeciesAndShapes made =
      makeSpecies(std::move(plans), problem.lumen, problem.request, problem.team, false, problem.notices);
  problem.species = withCounts(std::move(made.species), counts);
  problem.shapes = std::move(made.shapes);
  problem.demanded = clearances;
  problem.atDemanded = partsAt(problem, {}, clearances);
  problem.species =
      withMeanVolumes(std::move(problem.species), averagePlaced(problem, problem.atDemanded.parts),
                      problem.request.redCellVolume);
  problem.read = linesOfPresent(problem.species);
  return problem;
}

Problem withCorrectedProfile(Problem problem, const PackingResult& packed) {
  problem.layout.profile = correctedProfile(problem, packed);
  if (problem.hasDeformed()) {
    Division division = dividedByVolume(problem, problem.hematocrit, problem.layout);
    problem.species = std::move(division.species);
    problem.atDemanded = std::move(division.parts);
  } else {
    problem.atDemanded = partsAt(problem, problem.layout, problem.demanded);
  }
  return problem;
}

std::optional<std::string> missedHematocritWarning(const Problem& problem) {
  if (!problem.hematocrit || !problem.hasDeformed() || !problem.layout.regions.empty()) return {};
  double volume = 0.0, cell = 0.0;
  for (const CellSpecies& species : problem.species) {
    if (!species.sharesHematocrit) continue;
    volume += double(species.count) * species.countedVolume;
    cell = std::max(cell, species.countedVolume);
  }
  const double lumen = problem.referenceVolume();
  if (std::abs(volume - *problem.hematocrit * lumen) <= cell) return {};
  return fmt::format("the hematocrit will be {:.4f} instead of {:.4f}: the volumes of the cells differ",
                     volume / lumen, *problem.hematocrit);
}

PackingProblem packingProblemOf(const Problem& problem, const PartsToPack& packed,
                                std::function<bool()> interrupted,
                                std::function<void(const Progress&)> progress) {
  const Request& request = problem.request;
  PackingProblem packing;
  Physics& physics = packing.physics;
  Execution& execution = packing.execution;
  double redCells = 0.0;
  for (const CellSpecies& species : problem.species)
    if (species.redCell) redCells += double(species.count);
  for (const Part& part : packed.parts) {
    const CellSpecies& species = problem.species[part.species];
    physics.species.push_back(part.cells);
    physics.species.back().kind = species.name;
    if (species.ratio && part.cells.count == species.count)
      physics.species.back().asked = *species.ratio * redCells;
  }
  physics.shapes = problem.shapes;
  physics.container = problem.lumen.container;
  execution.communicator = problem.ranks;
  execution.threads = problem.team;
  if (request.method == Method::cat) packing.engine = engineFor(problem, packed);
  physics.clearance = packed.clearances.membranes;
  physics.wallClearance = packed.clearances.wall;
  physics.seed = request.seed;
  physics.rotate = request.rotate;
  if (request.inColumns) {
    const auto volume = [&](const Species& s) { return double(s.count) * meanVolume(s, physics.shapes); };
    const auto most =
        std::max_element(physics.species.begin(), physics.species.end(),
                         [&](const Species& a, const Species& b) { return volume(a) < volume(b); });
    if (most != physics.species.end() && most->count > 0) most->inColumns = true;
  }
  execution.limits.maxSeconds = request.maxSeconds;
  if (request.maxIterations) execution.limits.maxSweeps = *request.maxIterations;
  physics.written = [read = problem.read](const Pose& pose) { return placementOf(read->lineOf(pose)); };
  execution.interrupted = std::move(interrupted);
  execution.progress = std::move(progress);
  return packing;
}

void nameBySpecies(const PartsToPack& packed, PackingResult& result) {
  for (PlacedCell& cell : result.cells) cell.species = packed.parts[cell.species].species;
}

}  // namespace packmesh::hemocell
