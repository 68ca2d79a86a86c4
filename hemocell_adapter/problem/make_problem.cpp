// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/make_problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/hemocell/hemocell_limits.h"
#include "hemocell_adapter/problem/blood.h"
#include "hemocell_adapter/problem/code_facts.h"
#include "hemocell_adapter/problem/fahraeus.h"
#include "hemocell_adapter/problem/make_lumen.h"
#include "hemocell_adapter/problem/other_spacings.h"
#include "hemocell_adapter/problem/own_meshes.h"
#include "hemocell_adapter/problem/parts.h"
#include "hemocell_adapter/problem/plan_profile.h"
#include "hemocell_adapter/problem/resolve_counts.h"
#include "hemocell_adapter/problem/species_plans.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"
#include "packMesh/core/tolerances.h"

namespace packmesh::hemocell {
namespace {

std::shared_ptr<const Shape> shapeOf(const SpeciesPlan& species, double dx, const Threads& threads,
                                     std::vector<std::string>& repairs) {
  return located(fmt::format("cell '{}'", species.name), [&]() -> std::shared_ptr<const Shape> {
    switch (species.kind) {
      case SpeciesPlan::Template::model:
        return makeShape(species.model, dx, &repairs, threads);
      case SpeciesPlan::Template::mesh:
        return makeShapeFromFile(species.meshFile, species.meshScale, species.meshFrame, dx, repairs,
                                 threads);
      case SpeciesPlan::Template::built:
        return makeShapeOfBuilt(species.builtMesh, species.name, dx, threads);
      case SpeciesPlan::Template::ellipsoid:
        return makeEllipsoid(species.ellipsoidAxes.x(), species.ellipsoidAxes.y(), species.ellipsoidAxes.z());
    }
    return nullptr;
  });
}

/// Everything that determines a shape, except dx.
std::string keyOf(const SpeciesPlan& s) {
  const CellModel& m = s.model;
  if (s.kind == SpeciesPlan::Template::built) return s.name;
  return fmt::format("{} {} {} {} {} {} {} '{}' {} '{}'", int(s.meshFrame), int(s.kind), int(m.construction),
                     m.radius, m.minNumTriangles, m.aspectRatio, fmt::join(s.ellipsoidAxes, " "),
                     m.stlFile.string(), s.meshScale, s.meshFile.string());
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

}  // namespace

std::vector<std::string> limitWarnings(const Problem& problem, const std::vector<std::int64_t>& counts) {
  std::vector<std::string> warnings;
  std::int64_t cells = 0;
  std::string longestCell;
  double longest = 0.0;
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    cells += counts[s];
    if (counts[s] == 0 || !problem.simulation) continue;
    const double length = longestExtent(problem.species[s].shape->mesh());
    if (length <= longest) continue;
    longest = length;
    longestCell = problem.species[s].name;
  }
  std::optional<std::array<int, 3>> nodes;
  if (problem.lumen.lattice) nodes = problem.lumen.lattice->nodes();
  if (longest > 0.0)
    if (auto warning = envelopeWarning(longestCell, longest, problem.simulation->domain, nodes))
      warnings.push_back(std::move(*warning));
  const CaseSource noCode;
  const CaseSource& code = problem.simulation ? problem.simulation->source : noCode;
  if (auto warning = cellNumberWarning(cells, code.periodicity)) warnings.push_back(std::move(*warning));
  return warnings;
}

namespace {

/// Makes the shapes of the deformed cells of a species.
void addDeformed(Problem& problem, int s, bool packs) {
  CellSpecies& species = problem.species[s];
  const auto add = [&](std::vector<PresentCell>& cells, const std::string& file, SelfIntersecting what) {
    std::vector<OwnMesh> meshes;
    for (PresentCell& cell : cells)
      if (!cell.vertices.empty()) meshes.push_back({&cell, s, &species.ownTriangles});
    addOwnMeshes(problem, meshes, file, what);
  };
  add(species.fixed, species.fixedFrom, SelfIntersecting::keep);
  if (packs) refuseSelfIntersecting(problem, species.fixed, s, species.fixedFrom);
  add(species.start, species.startFrom, packs ? SelfIntersecting::undeform : SelfIntersecting::keep);
}

/// Species of a problem that has its lumen, with their shapes and HemoCell's acceptance of them.
/// @param packs they are to be packed, not examined
void addSpecies(Problem& problem, std::vector<SpeciesPlan> plans, bool packs) {
  // Species with equal shapes share their data.
  std::map<std::string, std::shared_ptr<const Shape>> shapes;
  std::map<int, std::shared_ptr<const Acceptance>> acceptances;  // by distance from solid
  for (SpeciesPlan& plan : plans) {
    std::shared_ptr<const Shape>& shape = shapes[keyOf(plan)];
    if (!shape) shape = shapeOf(plan, problem.request.dx, problem.team, problem.repairs);
    CellSpecies& species = problem.species.emplace_back(std::move(plan));
    problem.shapes.push_back(species.shape = shape);
    species.countedVolume = species.meanVolume = shape->volume();
    if (species.redCell && problem.request.redCellVolume)
      species.countedVolume = *problem.request.redCellVolume;
    refuseHeapedStart(species);
    if (problem.lumen.lattice) {
      const int distance = species.minimumDistanceFromSolid;
      std::shared_ptr<const Acceptance>& acceptance = acceptances[distance];
      if (!acceptance) acceptance = std::make_shared<Acceptance>(problem.lumen.lattice, distance);
      species.acceptance = acceptance;
      species.others = otherAcceptances(species, problem.lumen);
    }
  }
  for (std::size_t s = 0; s < problem.species.size(); ++s) addDeformed(problem, int(s), packs);
}

/// Clearances and layers for which this lumen has no wall.
void examineWall(Problem& problem) {
  const Request& request = problem.request;
  const bool wall = problem.lumen.container->wall();
  if (!request.choosesWallClearance() && problem.demanded.wall > 0.0 && !wall)
    problem.notices.emplace_back(
        "the clearance to the wall has no effect: the lumen is periodic and has no wall");
  if (request.cellFreeLayer > 0.0 && !(wall && problem.lumen.solidWalls))
    throw InputError("a cell-free layer requires walls, and this lumen has none (see " + named("walls") +
                     ")");
}

void chooseTubeHematocrit(Problem& problem) {
  const double discharge = *problem.request.dischargeHematocrit;
  const auto diameter =
      problem.lumen.solidWalls ? hydraulicDiameter(*problem.lumen.container, endAxes(problem)) : std::nullopt;
  if (!diameter)
    throw InputError(
        "a discharge hematocrit is that of a lumen with walls that blood flows along, and this one has none "
        "(see " +
        named("walls") + "); state the hematocrit");
  if (auto warning = fahraeusWarning(*diameter))
    problem.notices.push_back("discharge hematocrit: " + *warning);
  problem.request.hematocrit = tubeHematocrit(discharge, *diameter);
}

/// Takes the mean volumes of the cells that are placed. @return whether other numbers of them follow
bool takeVolumes(Problem& problem) {
  if (!problem.hasDeformed()) return false;
  std::vector<double> volumes(problem.species.size(), 0.0);
  for (const Part& part : problem.atDemanded.parts)
    part.cells.forEachShape([&](int shape, std::int64_t cells) {
      volumes[part.species] += double(cells) * problem.shapes[shape]->volume();
    });
  std::vector<std::int64_t> before;
  for (std::size_t s = 0; s < volumes.size(); ++s) {
    CellSpecies& species = problem.species[s];
    before.push_back(species.count);
    if (species.count == 0) continue;
    species.meanVolume = volumes[s] / double(species.count);
    if (!(species.redCell && problem.request.redCellVolume)) species.countedVolume = species.meanVolume;
  }
  return numbersOfCells(problem) != before;
}

/// Numbers of cells, their profile and their parts. With deformed cells the numbers depend on the volumes of
/// those that are placed, and these on the numbers.
void divideIntoParts(Problem& problem) {
  constexpr int mostRounds = 6;  // two or three are enough, unless the numbers alternate
  guessVolumes(problem);
  std::vector<std::string> notices;
  for (int round = 0; round == 0 || (round < mostRounds && takeVolumes(problem)); ++round) {
    const std::vector<std::int64_t> numbers = numbersOfCells(problem);
    for (std::size_t s = 0; s < numbers.size(); ++s) problem.species[s].count = numbers[s];
    notices.clear();
    if (!problem.hasDeformed()) examineNumbers(problem);
    if (problem.request.profile) problem.profile = planProfile(problem, notices);
    if (!problem.hasDeformed() && problem.profile) refuseTooDense(problem);
    problem.atDemanded = partsAt(problem, problem.demanded);
  }
  if (problem.hasDeformed()) {
    takeVolumes(problem);
    examineNumbers(problem);
    if (problem.profile) refuseTooDense(problem);
  }
  for (std::string& notice : notices) problem.notices.push_back(std::move(notice));
}

/// Regions, counts, parts and walls of a problem that has its lumen and its shapes.
void preparePacking(Problem& problem) {
  const Request& request = problem.request;
  if (!request.regions.empty() && !request.hematocrit)
    throw InputError(
        request.regions.front().body.where +
        ": regions require a hematocrit of the rest of the lumen; 0: red cells in regions alone");
  if (request.regions.empty() && request.hematocrit && *request.hematocrit == 0.0)
    throw InputError(named("hematocrit", "0") + " asks for no red cells; use it with regions");
  examineWall(problem);
  if (request.profile && !request.regions.empty())
    throw InputError(request.regions.front().body.where + ": regions and a profile (" + named("profile") +
                     ", <profile>) exclude each other");
  if (request.profile && request.inColumns)
    throw InputError(named("order", "columns") + " (<order>) and a profile (" + named("profile") +
                     ", <profile>) exclude each other: both determine where the cells are");
  problem.lumen.regions = makeRegions(request, problem.lumen, problem.repairs);
  if (request.dischargeHematocrit) chooseTubeHematocrit(problem);
  divideIntoParts(problem);
  std::vector<std::int64_t> counts;
  std::int64_t tiles = 1;
  if (request.dryRun)
    for (const int n : request.tiles) tiles *= n;
  for (const CellSpecies& species : problem.species)
    // The larger box of --tile is a separate problem; a dry run makes none.
    counts.push_back(species.mostCells() * tiles);
  for (std::string& warning : limitWarnings(problem, counts)) problem.notices.push_back(std::move(warning));
  for (const CellSpecies& species : problem.species)
    for (const auto* lines : {&species.fixed, &species.start})
      for (const PosLine& line : *lines) problem.read.add(line);
  for (std::string& warning : examineRegions(problem)) problem.notices.push_back(std::move(warning));
}

/// Those of its lumen, too.
void takeNotices(Problem& problem) {
  const auto append = [](std::vector<std::string>& to, std::vector<std::string>& from) {
    to.insert(to.end(), from.begin(), from.end());
    from.clear();
  };
  append(problem.notices, problem.lumen.notices);
  append(problem.repairs, problem.lumen.repairs);
}

/// A problem with the lumen of its request.
/// @param complete adds species, and what else there is
Problem builtWith(const CompletedRequest& completed, const Communicator& ranks,
                  const std::function<void(Problem&)>& complete) {
  Problem problem;
  problem.request = completed.request;
  problem.demanded = completed.request.demanded();
  problem.simulation = completed.simulation;
  problem.preInlet = completed.preInlet;
  problem.ranks = ranks;
  problem.team = teamOf(problem.request.threads, ranks);
  problem.notices = completed.warnings;
  try {
    complete(problem);
  } catch (...) {
    takeNotices(problem);
    logNotices(problem);  // may explain the failure
    throw;
  }
  takeNotices(problem);
  return problem;
}

void addLumenAndSpecies(Problem& problem, std::vector<SpeciesPlan> plans, bool packs) {
  problem.inputs = recordedInputs();
  problem.lumen = makeLumen(problem.request, problem.simulation.get(), problem.preInlet);
  addOtherSpacings(problem.request, problem.simulation.get(), problem.preInlet, problem.lumen);
  // Membranes may extend further at another spacing.
  problem.demanded.membranes =
      std::max(problem.demanded.membranes, 2.0 * inflationElsewhere(problem.lumen, problem.request.dx));
  addSpecies(problem, std::move(plans), packs);
}

}  // namespace

void logNotices(const Problem& problem) {
  for (const std::string& notice : problem.notices) log::warning(notice);
  for (const std::string& repair : problem.repairs) log::repair(repair);
}

Problem problemToPack(const CompletedRequest& completed, const Communicator& ranks) {
  return builtWith(completed, ranks, [&](Problem& problem) {
    std::vector<SpeciesPlan> plans = plansToPack(problem.request, problem.simulation.get(), problem.notices);
    if (problem.simulation) settleDistancesFromSolid(*problem.simulation, plans, problem.notices);
    addLumenAndSpecies(problem, std::move(plans), true);
    addBlood(problem);
    preparePacking(problem);
  });
}

Problem problemToCheck(const CompletedRequest& completed, const Communicator& ranks) {
  return builtWith(completed, ranks, [&](Problem& problem) {
    CheckedSpecies found = plansToCheck(problem.request, problem.simulation.get(), problem.notices);
    problem.unchecked = std::move(found.unchecked);
    if (problem.simulation) settleDistancesFromSolid(*problem.simulation, found.plans, problem.notices);
    addLumenAndSpecies(problem, std::move(found.plans), false);
  });
}

void requireTileable(const Problem& problem) {
  double cells = 0.0, tiles = 1.0;
  const std::array<int, 3>& times = problem.request.tiles;
  for (const CellSpecies& species : problem.species) cells += double(species.count);
  for (int k = 0; k < 3; ++k) {
    tiles *= times[k];
    if (times[k] > 1 && !(problem.lumen.container->period()[k] > 0.0))
      throw InputError(fmt::format(
          named("tile") + ": the box is not periodic along {}, so it cannot be repeated", "xyz"[k]));
    if (times[k] * problem.lumen.container->bounds().size()[k] > specs::largestLength)
      throw InputError(fmt::format(named("tile") + ": the box would be more than {:.0f} µm long along {}",
                                   specs::largestLength, "xyz"[k]));
  }
  if (cells * tiles > specs::largestCount)
    throw InputError(fmt::format(named("tile") + ": {:.3g} cells are too many; at most {:.0f} can be packed",
                                 cells * tiles, specs::largestCount));
}

namespace {

/// A cell of the box that is repeated.
struct BoxedCell {
  PosLine line;
  int species, shape;
};

std::vector<BoxedCell> boxedCells(const Problem& problem, const PackingResult& result) {
  std::vector<BoxedCell> own;
  for (std::size_t i = 0; i < result.cells.size(); ++i)
    own.push_back({problem.read.lineOf(result.poses[i]), result.cells[i].species, result.cells[i].shape});
  return problem.ranks.gatherAll(own);
}

/// The species of a larger box with their cells, which are all there.
std::vector<SpeciesPlan> tiledPlans(const Problem& problem, const std::vector<BoxedCell>& cells) {
  std::vector<SpeciesPlan> plans(problem.species.begin(), problem.species.end());
  for (std::size_t s = 0; s < plans.size(); ++s) {
    SpeciesPlan& species = plans[s];
    species.fixed.clear();
    species.start.clear();
    species.ownTriangles = problem.species[s].shape->mesh().triangles;
    species.blood = {};
    species.fixedFrom.clear();
    species.startFrom = "the box that is repeated";
    species.ratio.reset();
  }
  const std::array<int, 3>& times = problem.request.tiles;
  const Vec3& box = *problem.request.boxSize;
  for (const BoxedCell& cell : cells) {
    std::vector<PresentCell>& images = plans[cell.species].start;
    for (int x = 0; x < times[0]; ++x)
      for (int y = 0; y < times[1]; ++y)
        for (int z = 0; z < times[2]; ++z) {
          images.emplace_back(
              PosLine{cell.line.position + Vec3(x, y, z).cwiseProduct(box), cell.line.angles});
          if (cell.shape != cell.species)
            images.back().vertices = problem.shapes[cell.shape]->mesh().vertices;
        }
  }
  for (SpeciesPlan& species : plans) species.statedCount = std::int64_t(species.start.size());
  return plans;
}

}  // namespace

Problem tiledProblem(const Problem& problem, const Clearances& clearances, const PackingResult& result) {
  CompletedRequest big{problem.request, problem.simulation, {}, {}};
  big.request.tiles = {1, 1, 1};
  big.request.regions.clear();
  big.request.inColumns = false;  // they are there
  big.request.profile.reset();
  big.request.dischargeHematocrit.reset();
  big.request.hematocrit.reset();
  for (int k = 0; k < 3; ++k) (*big.request.boxSize)[k] *= problem.request.tiles[k];
  return builtWith(big, problem.ranks, [&](Problem& made) {
    made.demanded = clearances;
    addLumenAndSpecies(made, tiledPlans(problem, boxedCells(problem, result)), false);
    preparePacking(made);
  });
}

Problem withCorrectedProfile(const Problem& problem, const PackingResult& packed) {
  Problem corrected = problem;
  corrected.profile = correctedProfile(problem, packed);
  corrected.atDemanded = partsAt(corrected, corrected.demanded);
  return corrected;
}

PackingProblem packingProblemOf(const Problem& problem, const PackedParts& packed,
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
  physics.written = [&problem](const Pose& pose) { return placementOf(problem.read.lineOf(pose)); };
  execution.interrupted = std::move(interrupted);
  execution.progress = std::move(progress);
  return packing;
}

void nameBySpecies(const PackedParts& packed, PackingResult& result) {
  for (PlacedCell& cell : result.cells) cell.species = packed.parts[cell.species].species;
}

}  // namespace packmesh::hemocell
