// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/problem.h"

#include <algorithm>
#include <cmath>

#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/problem/other_spacings.h"
#include "packMesh/core/tolerances.h"

namespace packmesh::hemocell {

std::string columnsInstead(const Problem& problem) {
  const bool bound = std::any_of(problem.species.begin(), problem.species.end(), [](const CellSpecies& s) {
    return s.cone || !s.fixed.empty() || !s.start.empty();
  });
  const bool possible = !problem.request.inColumns && problem.request.regions.empty() &&
                        problem.request.method == Method::relaxation && problem.request.rotate && !bound &&
                        problem.lumen.container->period().minCoeff() > 0.0;
  return possible ? "; " + named("order", "columns") + " packs red cells up to 0.65, not at random" : "";
}

Physics physicsOf(const Problem& problem) {
  Physics physics;
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    const CellSpecies& one = problem.species[s];
    Species species{one.name, int(s), one.mostCells(), nullptr, one.redCell};
    species.freedom.extraWallClearance = one.extraWallClearance(problem.demanded.wall);
    physics.species.push_back(std::move(species));
  }
  physics.shapes = problem.shapes;
  physics.container = problem.lumen.container;
  physics.clearance = problem.demanded.membranes;
  physics.wallClearance = problem.demanded.wall;
  physics.rotate = problem.request.rotate;
  physics.seed = problem.request.seed;
  return physics;
}

std::array<bool, 3> endAxes(const Problem& problem) {
  if (problem.running() && !problem.request.container) return problem.running()->periodic;
  std::array<bool, 3> ends{};
  const auto allBut = [&](const std::string& walls) {
    for (int k = 0; k < 3; ++k) ends[k] = walls.find("xyz"[k]) == std::string::npos;
  };
  if (problem.request.container && problem.request.container->lumen) {
    const SolidRequest& solid = *problem.request.container->lumen;
    if (solid.kind == SolidRequest::Kind::cylinder) ends[solid.axis] = true;
    if (solid.kind == SolidRequest::Kind::mesh && solid.openAxis) ends[*solid.openAxis] = true;
    if (solid.kind == SolidRequest::Kind::box)
      allBut(problem.request.walls.value_or(problem.request.periodicEnds.value_or(false) ? "" : "xyz"));
  } else if (problem.request.boxSize || !problem.simulation->domain.geometry) {
    allBut(problem.request.walls.value_or(""));
  } else {
    ends[problem.preInlet ? problem.preInlet->axis : 0] = true;
  }
  return ends;
}

bool knowsAcceptance(const Problem& problem) {
  return problem.lumen.lattice || problem.lumen.keptBox;
}

Loading loadingOf(const Problem& problem, const std::vector<PlacedCell>& own) {
  const bool deformed =
      std::any_of(own.begin(), own.end(), [&](const PlacedCell& cell) { return problem.isDeformed(cell); });
  return problem.ranks.any(deformed) ? Loading::plugIn : Loading::posFiles;
}

namespace {

/// The verdict on a cell where the lattice is repeated along these axes.
std::optional<std::string> violationIn(const Problem& problem, const PlacedCell& cell, Loading loading,
                                       const std::array<bool, 3>& periodic) {
  const CellSpecies& species = problem.species[cell.species];
  const Shape& shape = *problem.shapes[cell.shape];
  const auto vertices = [&] { return placedVertices(shape.mesh(), cell.placement); };
  if (species.acceptance) {
    const bool deformed = shape.undeformed() != nullptr;
    if (auto violation =
            species.acceptance->violation(vertices(), {periodic, loading == Loading::plugIn && deformed}))
      return violation;
    return violationElsewhere(species, problem.lumen, cell.placement, deformed ? &shape.mesh() : nullptr);
  }
  if (problem.lumen.keptBox) {
    const Sphere sphere = boundingSphere(shape.hierarchy(), cell.placement);
    if (problem.lumen.keptBox->grownBy(-sphere.radius).contains(sphere.center)) return {};
    for (const Vec3& p : vertices())
      for (int k = 0; k < 3; ++k)
        if (!periodic[k] && !(p[k] > problem.lumen.keptBox->lo[k] && p[k] <= problem.lumen.keptBox->hi[k]))
          return "a vertex lies outside the lattice";
  }
  return {};
}

}  // namespace

std::optional<std::string> hemocellViolation(const Problem& problem, const PlacedCell& cell,
                                             Loading loading) {
  const auto inFiles = loading == Loading::posFiles ? violationIn(problem, cell, loading, {}) : std::nullopt;
  if (loading == Loading::posFiles && (!inFiles || !problem.lumen.periodic)) return inFiles;
  std::array<bool, 3> periodic{};
  for (int k = 0; k < 3; ++k) periodic[k] = problem.lumen.container->period()[k] > 0.0;
  auto violation = violationIn(problem, cell, loading, periodic);
  if (!violation && inFiles) return crossesFace;
  return violation;
}

void forEachVerdict(const Problem& problem, const std::vector<PlacedCell>& cells, Loading loading,
                    const std::function<void(std::size_t, const std::optional<std::string>&)>& visit) {
  constexpr std::size_t atATime = 8192;
  std::vector<std::optional<std::string>> violations(std::min(cells.size(), atATime));
  for (std::size_t begin = 0; begin < cells.size(); begin += atATime) {
    const std::size_t count = std::min(cells.size() - begin, atATime);
    problem.team.forEachPart(
        static_cast<std::int64_t>(count),
        [&](std::int64_t first, std::int64_t end, int) {
          for (std::int64_t i = first; i < end; ++i)
            violations[i] = hemocellViolation(problem, cells[begin + i], loading);
        },
        64);
    for (std::size_t i = 0; i < count; ++i) visit(begin + i, violations[i]);
  }
}

std::vector<std::int64_t> countsOf(const Problem& problem, const std::vector<PlacedCell>& cells) {
  std::vector<std::int64_t> counts(problem.species.size(), 0);
  for (const PlacedCell& cell : cells) ++counts[cell.species];
  return counts;
}

std::vector<std::int64_t> deformedCounts(const Problem& problem, const std::vector<PlacedCell>& own) {
  std::vector<std::int64_t> counts(problem.species.size(), 0);
  for (const PlacedCell& cell : own) counts[cell.species] += problem.isDeformed(cell);
  problem.ranks.sum(counts);
  return counts;
}

std::vector<double> excessVolumes(const Problem& problem, const std::vector<PlacedCell>& own,
                                  const std::function<bool(std::size_t)>& counts) {
  constexpr double steps = 0x1p20;  // per µm³: the sum of whole numbers does not depend on their order
  std::vector<std::int64_t> sums(problem.species.size(), 0);
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (!problem.isDeformed(own[i]) || (counts && !counts(i))) continue;
    const double undeformed = problem.shapes[own[i].species]->volume();
    sums[own[i].species] += std::llround(steps * (problem.shapes[own[i].shape]->volume() - undeformed));
  }
  if (problem.hasDeformed()) problem.ranks.sum(sums);
  std::vector<double> excess;
  for (const std::int64_t sum : sums) excess.push_back(double(sum) / steps);
  return excess;
}

Tally tallyOf(const Problem& problem, std::vector<std::int64_t> counts, const std::vector<double>& excess) {
  Tally tally;
  tally.counts = std::move(counts);
  tally.meshVolume.assign(problem.species.size(), 0.0);
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    const CellSpecies& species = problem.species[s];
    const double n = double(tally.counts[s]);
    tally.meshVolume[s] = n * species.shape->volume() + excess[s];
    if (!species.redCell || n == 0) continue;
    tally.redCells += tally.counts[s];
    tally.redMesh += tally.meshVolume[s];
    if (species.model.hemocellVolume) {
      tally.redHemocell += n * *species.model.hemocellVolume;
    } else {
      tally.hemocellKnown = false;
    }
  }
  return tally;
}

}  // namespace packmesh::hemocell
