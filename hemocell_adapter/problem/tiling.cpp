// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/tiling.h"

#include <fmt/format.h>

#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {

void requireTileable(const Scene& scene) {
  double cells = 0.0, tiles = 1.0;
  for (const CellSpecies& species : scene.species) cells += double(species.count);
  for (int k = 0; k < 3; ++k) {
    tiles *= scene.tiles[k];
    if (scene.tiles[k] > 1 && !(scene.lumen.container->period()[k] > 0.0))
      throw InputError(
          fmt::format("--tile: the box is not periodic along {}, so it cannot be repeated", "xyz"[k]));
    if (scene.tiles[k] * scene.lumen.container->bounds().size()[k] > specs::largestLength)
      throw InputError(fmt::format("--tile: the box would be more than {:.0f} µm long along {}",
                                   specs::largestLength, "xyz"[k]));
  }
  if (cells * tiles > specs::largestCount)
    throw InputError(fmt::format("--tile: {:.3g} cells are too many; at most {:.0f} can be packed",
                                 cells * tiles, specs::largestCount));
}

Job tiledJob(const Scene& scene, const PackingResult& result, const Communicator& ranks) {
  struct Line {
    double number[6];
    int species;
  };
  std::vector<Line> own;
  for (std::size_t i = 0; i < result.cells.size(); ++i) {
    const PosLine line = scene.read.lineOf(result.poses[i]);
    Line plain{};
    for (int k = 0; k < 6; ++k) plain.number[k] = k < 3 ? line.position[k] : line.angles[k - 3];
    plain.species = result.cells[i].species;
    own.push_back(plain);
  }
  Job big = static_cast<const Job&>(scene);
  big.demanded = scene.clearances;
  big.tiles = {1, 1, 1};
  big.regions.clear();
  big.hematocrit.reset();
  for (int k = 0; k < 3; ++k) (*big.boxSize)[k] *= scene.tiles[k];
  for (CellSpecies& species : big.species) {
    species.fixed.clear();
    species.start.clear();
    species.fixedFrom.clear();
    species.startFrom = "the box that is repeated";
    species.ratio.reset();
  }
  const std::vector<Line> all = ranks.gatherAll(own);
  for (const Line& line : all)
    for (int x = 0; x < scene.tiles[0]; ++x)
      for (int y = 0; y < scene.tiles[1]; ++y)
        for (int z = 0; z < scene.tiles[2]; ++z)
          big.species[line.species].start.push_back(
              {Vec3(line.number[0] + x * (*scene.boxSize)[0], line.number[1] + y * (*scene.boxSize)[1],
                    line.number[2] + z * (*scene.boxSize)[2]),
               Vec3(line.number[3], line.number[4], line.number[5])});
  for (CellSpecies& species : big.species) species.statedCount = std::int64_t(species.start.size());
  return big;
}

}  // namespace packmesh::hemocell
