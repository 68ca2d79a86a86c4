// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/problem.h"

#include <algorithm>
#include <cmath>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/problem/other_spacings.h"
#include "packMesh/core/tolerances.h"

namespace packmesh::hemocell {

void Notices::append(const Notices& later) {
  warnings.insert(warnings.end(), later.warnings.begin(), later.warnings.end());
  repairs.insert(repairs.end(), later.repairs.begin(), later.repairs.end());
}

std::string deformedInstead(const Scene& scene) {
  const bool possible = !scene.request.deforms() && scene.request.method == Method::relaxation;
  return possible ? "; " + named("soft") + " lets cells deform where undeformed ones do not fit" : "";
}

std::string denserInstead(const Scene& scene) {
  const bool bound = std::any_of(scene.species.begin(), scene.species.end(), [](const CellSpecies& s) {
    return s.cone || !s.fixed.empty() || !s.start.empty();
  });
  const bool possible = !scene.request.inColumns && scene.request.regions.empty() &&
                        scene.request.method == Method::relaxation && scene.request.rotate && !bound &&
                        scene.lumen.container->period().minCoeff() > 0.0;
  return (possible ? "; " + named("order", "columns") + " packs red cells up to 0.65, not at random" : "") +
         deformedInstead(scene);
}

Physics physicsOf(const Scene& scene) {
  Physics physics;
  for (std::size_t s = 0; s < scene.species.size(); ++s) {
    const CellSpecies& one = scene.species[s];
    Species species{one.name, int(s), one.mostCells(), nullptr, one.redCell};
    species.freedom.extraWallClearance = one.extraWallClearance(scene.demanded.wall);
    physics.species.push_back(std::move(species));
  }
  physics.shapes = scene.shapes;
  physics.container = scene.lumen.container;
  physics.clearance = scene.demanded.membranes;
  physics.wallClearance = scene.demanded.wall;
  physics.rotate = scene.request.rotate;
  physics.seed = scene.request.seed;
  return physics;
}

std::array<bool, 3> endAxes(const Scene& scene) {
  if (scene.running() && !scene.request.container) return scene.running()->periodic;
  std::array<bool, 3> ends{};
  const auto allBut = [&](const std::string& walls) {
    for (int k = 0; k < 3; ++k) ends[k] = walls.find("xyz"[k]) == std::string::npos;
  };
  if (scene.request.container && scene.request.container->lumen) {
    const SolidRequest& solid = *scene.request.container->lumen;
    if (solid.kind == SolidRequest::Kind::cylinder) ends[solid.axis] = true;
    if (solid.kind == SolidRequest::Kind::mesh && solid.openAxis) ends[*solid.openAxis] = true;
    if (solid.kind == SolidRequest::Kind::box)
      allBut(scene.request.walls.value_or(scene.request.periodicEnds.value_or(false) ? "" : "xyz"));
  } else if (scene.request.boxSize || !scene.simulation->domain.geometry) {
    allBut(scene.request.walls.value_or(""));
  } else {
    ends[scene.preInlet ? scene.preInlet->axis : 0] = true;
  }
  return ends;
}

bool knowsAcceptance(const Scene& scene) {
  return scene.lumen.lattice || scene.lumen.keptBox;
}

Loading loadingOf(const Scene& scene, const std::vector<PlacedCell>& own) {
  const bool deformed =
      std::any_of(own.begin(), own.end(), [&](const PlacedCell& cell) { return scene.isDeformed(cell); });
  return scene.ranks.any(deformed) ? Loading::plugIn : Loading::posFiles;
}

namespace {

/// The verdict on a cell where the lattice is repeated along these axes.
std::optional<std::string> violationIn(const Scene& scene, const PlacedCell& cell, Loading loading,
                                       const std::array<bool, 3>& periodic) {
  const CellSpecies& species = scene.species[cell.species];
  const Shape& shape = *scene.shapes[cell.shape];
  const auto vertices = [&] { return placedVertices(shape.mesh(), cell.placement); };
  if (species.acceptance) {
    const bool deformed = shape.undeformed() != nullptr;
    if (auto violation =
            species.acceptance->violation(vertices(), {periodic, loading == Loading::plugIn && deformed}))
      return violation;
    return violationElsewhere(species, scene.lumen, cell.placement, deformed ? &shape.mesh() : nullptr);
  }
  if (scene.lumen.keptBox) {
    const Sphere sphere = boundingSphere(shape.sphere(), cell.placement);
    if (scene.lumen.keptBox->grownBy(-sphere.radius).contains(sphere.center)) return {};
    for (const Vec3& p : vertices())
      for (int k = 0; k < 3; ++k)
        if (!periodic[k] && !(p[k] > scene.lumen.keptBox->lo[k] && p[k] <= scene.lumen.keptBox->hi[k]))
          return "a vertex lies outside the lattice";
  }
  return {};
}

}  // namespace

std::optional<std::string> hemocellViolation(const Scene& scene, const PlacedCell& cell, Loading loading) {
  const auto inFiles = loading == Loading::posFiles ? violationIn(scene, cell, loading, {}) : std::nullopt;
  if (loading == Loading::posFiles && (!inFiles || !scene.lumen.periodic)) return inFiles;
  std::array<bool, 3> periodic{};
  for (int k = 0; k < 3; ++k) periodic[k] = scene.lumen.container->period()[k] > 0.0;
  auto violation = violationIn(scene, cell, loading, periodic);
  if (!violation && inFiles) return crossesFace;
  return violation;
}

void forEachVerdict(const Scene& scene, const std::vector<PlacedCell>& cells, Loading loading,
                    const std::function<void(std::size_t, const std::optional<std::string>&)>& visit) {
  constexpr std::size_t atATime = 8192;
  std::vector<std::optional<std::string>> violations(std::min(cells.size(), atATime));
  for (std::size_t begin = 0; begin < cells.size(); begin += atATime) {
    const std::size_t count = std::min(cells.size() - begin, atATime);
    scene.team.forEachPart(
        static_cast<std::int64_t>(count),
        [&](std::int64_t first, std::int64_t end, int) {
          for (std::int64_t i = first; i < end; ++i)
            violations[i] = hemocellViolation(scene, cells[begin + i], loading);
        },
        64);
    for (std::size_t i = 0; i < count; ++i) visit(begin + i, violations[i]);
  }
}

std::vector<std::int64_t> countsOf(const Scene& scene, const std::vector<PlacedCell>& cells) {
  std::vector<std::int64_t> counts(scene.species.size(), 0);
  for (const PlacedCell& cell : cells) ++counts[cell.species];
  return counts;
}

std::vector<std::int64_t> deformedCounts(const Scene& scene, const std::vector<PlacedCell>& own) {
  std::vector<std::int64_t> counts(scene.species.size(), 0);
  for (const PlacedCell& cell : own) counts[cell.species] += scene.isDeformed(cell);
  scene.ranks.sum(counts);
  return counts;
}

std::vector<double> excessVolumes(const Scene& scene, const std::vector<PlacedCell>& own,
                                  const std::function<bool(std::size_t)>& counts) {
  constexpr double steps = 0x1p20;  // per µm³: the sum of whole numbers does not depend on their order
  std::vector<std::int64_t> sums(scene.species.size(), 0);
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (!scene.isDeformed(own[i]) || (counts && !counts(i))) continue;
    const double undeformed = scene.shapes[own[i].species]->volume();
    sums[own[i].species] += std::llround(steps * (scene.shapes[own[i].shape]->volume() - undeformed));
  }
  if (scene.hasDeformed()) scene.ranks.sum(sums);
  std::vector<double> excess;
  for (const std::int64_t sum : sums) excess.push_back(double(sum) / steps);
  return excess;
}

Tally tallyOf(const Scene& scene, std::vector<std::int64_t> counts, const std::vector<double>& excess) {
  Tally tally;
  tally.counts = std::move(counts);
  tally.meshVolume.assign(scene.species.size(), 0.0);
  for (std::size_t s = 0; s < scene.species.size(); ++s) {
    const CellSpecies& species = scene.species[s];
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
