// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/own_meshes.h"

#include <fmt/format.h>

#include <utility>

#include "packMesh/core/error.h"

namespace packmesh::hemocell {

void addOwnMeshes(Problem& problem, const std::vector<OwnMesh>& meshes, const std::string& file) {
  for (const OwnMesh& mesh : meshes)
    if (problem.species[mesh.species].shape->mesh().triangles != *mesh.triangles)
      throw InputError(fmt::format(
          "{}: its cells '{}' have meshes of their own whose triangles are not those of the template", file,
          problem.species[mesh.species].name));
  const std::size_t first = problem.membranes.size();
  problem.membranes.resize(first + meshes.size());
  problem.team.forEach(std::int64_t(meshes.size()), [&](std::int64_t i, int) {
    PresentCell& cell = *meshes[i].cell;
    cell.membrane = int(first + i);
    problem.membranes[first + i] = {meshes[i].species,
                                    std::make_shared<const Shape>(std::exchange(cell.vertices, {}),
                                                                  problem.species[meshes[i].species].shape)};
  });
  for (std::size_t i = 0; i < meshes.size(); ++i)
    if (!(problem.membranes[first + i].shape->volume() > 0.0))
      throw InputError(
          fmt::format("{}: the mesh of a cell '{}' near ({:.6g}, {:.6g}, {:.6g}) µm is inside out", file,
                      problem.species[meshes[i].species].name, meshes[i].cell->position[0],
                      meshes[i].cell->position[1], meshes[i].cell->position[2]));
}

}  // namespace packmesh::hemocell
