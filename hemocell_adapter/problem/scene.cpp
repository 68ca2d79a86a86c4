// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/scene.h"

#include <algorithm>
#include <cmath>

#include "packMesh/core/tolerances.h"

namespace packmesh::hemocell {

std::string columnsInstead(const Scene& scene) {
  const bool bound = std::any_of(scene.species.begin(), scene.species.end(), [](const CellSpecies& s) {
    return s.cone || !s.fixed.empty() || !s.start.empty();
  });
  const bool possible = !scene.inColumns && scene.regions.empty() && scene.method == Method::relaxation &&
                        scene.rotate && !bound && scene.lumen.container->period().minCoeff() > 0.0;
  return possible ? "; --order columns packs red cells up to 0.65, not at random" : "";
}

std::vector<std::int64_t> namedBySpecies(const Scene& scene, PackingResult& result) {
  std::vector<std::int64_t> counts(scene.parts.size(), 0);
  for (PlacedCell& cell : result.cells) {
    ++counts[cell.species];
    cell.species = scene.parts[cell.species].species;
  }
  return counts;
}

bool knowsAcceptance(const Scene& scene) {
  return scene.lumen.lattice || scene.lumen.keptBox;
}

std::optional<std::string> hemocellViolation(const Scene& scene, const PlacedCell& cell) {
  const CellSpecies& species = scene.species[cell.species];
  const auto vertices = [&] { return placedVertices(species.shape->mesh(), cell.placement); };
  if (species.acceptance) return species.acceptance->violation(vertices());
  if (scene.lumen.keptBox) {
    const Sphere sphere = boundingSphere(species.shape->hierarchy(), cell.placement);
    if (scene.lumen.keptBox->grownBy(-sphere.radius).contains(sphere.center)) return {};
    for (const Vec3& p : vertices()) {
      const bool kept = (p.array() > scene.lumen.keptBox->lo.array()).all() &&
                        (p.array() <= scene.lumen.keptBox->hi.array()).all();
      if (!kept) return "a vertex lies outside the lattice";
    }
  }
  return {};
}

void forEachVerdict(const Scene& scene, const std::vector<PlacedCell>& cells,
                    const std::function<void(std::size_t, const std::optional<std::string>&)>& visit) {
  constexpr std::size_t atATime = 8192;
  std::vector<std::optional<std::string>> violations(std::min(cells.size(), atATime));
  for (std::size_t begin = 0; begin < cells.size(); begin += atATime) {
    const std::size_t count = std::min(cells.size() - begin, atATime);
    scene.team.forEachPart(
        static_cast<std::int64_t>(count),
        [&](std::int64_t first, std::int64_t end, int) {
          for (std::int64_t i = first; i < end; ++i)
            violations[i] = hemocellViolation(scene, cells[begin + i]);
        },
        64);
    for (std::size_t i = 0; i < count; ++i) visit(begin + i, violations[i]);
  }
}

std::vector<std::int64_t> countsOf(const Scene& scene, const std::vector<PlacedCell>& cells,
                                   const std::vector<std::int64_t>* chosen) {
  std::vector<std::int64_t> counts(scene.species.size(), 0);
  if (chosen) {
    for (const std::int64_t i : *chosen) ++counts[cells[i].species];
  } else {
    for (const PlacedCell& cell : cells) ++counts[cell.species];
  }
  return counts;
}

Tally tallyOf(const Scene& scene, std::vector<std::int64_t> counts) {
  Tally tally;
  tally.counts = std::move(counts);
  tally.meshVolume.assign(scene.species.size(), 0.0);
  for (std::size_t s = 0; s < scene.species.size(); ++s) {
    const CellSpecies& species = scene.species[s];
    const double n = double(tally.counts[s]);
    tally.meshVolume[s] = n * species.shape->volume();
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
