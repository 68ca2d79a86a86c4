// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/tiling.h"

#include <fmt/format.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {

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

/// The species of a larger box with their cells, which are all there. All ranks call.
std::vector<SpeciesPlan> tiledPlans(const Problem& problem, const PackingResult& result) {
  std::vector<PosLine> lines;
  for (const Pose& pose : result.poses) lines.push_back(problem.read->lineOf(pose));
  lines = problem.ranks.gatherAll(lines);
  const std::vector<PlacedCell> cells = problem.ranks.gatherAll(result.cells);
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
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const PlacedCell& cell = cells[i];
    std::vector<PresentCell>& images = plans[cell.species].start;
    for (int x = 0; x < times[0]; ++x)
      for (int y = 0; y < times[1]; ++y)
        for (int z = 0; z < times[2]; ++z) {
          images.emplace_back(PosLine{lines[i].position + Vec3(x, y, z).cwiseProduct(box), lines[i].angles});
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
  return problemWithCells(big, tiledPlans(problem, result), clearances, problem.ranks);
}

}  // namespace packmesh::hemocell
