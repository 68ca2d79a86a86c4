// SPDX-License-Identifier: AGPL-3.0-or-later
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "hemocell_adapter/cat/cat.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "packMesh/cat/cat_cells.h"
#include "packMesh/cat/cat_engine.h"
#include "packMesh/cat/tetrahedra.h"

namespace packmesh::hemocell {

bool hasCat() {
  return true;
}

std::shared_ptr<const Engine> engineFor(const Problem& problem, const PartsToPack& packed) {
  auto engine = std::make_shared<CatEngine>(problem.request.cat);
  if (engine->settings.escape)
    for (const Part& part : packed.parts)
      engine->settings.escape->reserve.push_back(
          part.cells.usesTemplate() ? problem.species[part.species].stock : 0);
  return engine;
}

std::vector<NamedMesh> catCellsOf(const std::vector<PlacedCell>& all, const Physics& physics) {
  TetrahedraInput input;
  for (const PlacedCell& cell : all)
    input.objects.push_back({&physics.shapeOf(cell).hierarchy(), cell.placement});
  std::optional<MeshHierarchy> lumen;
  if (physics.container->wall()) lumen.emplace(physics.container->surface());
  input.container = lumen ? &*lumen : nullptr;
  input.period = physics.container->period();
  input.bounds = physics.container->bounds();
  input.explain = false;
  std::vector<NamedMesh> meshes;
  try {
    const CatCells cells = catCells(tetrahedralise(input), WallFaces::atWall);
    for (std::size_t i = 0; i < cells.cells.size(); ++i)
      meshes.push_back({std::to_string(i), cells.cells[i], "cell"});
  } catch (const std::runtime_error&) {  // TetGen failed, or the lumen's surface touches a cell
    meshes.clear();
  }
  return meshes;
}

}  // namespace packmesh::hemocell
