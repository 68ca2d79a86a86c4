// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/own_meshes.h"

#include <fmt/format.h>

#include <utility>

#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

/// Least volume of a deformed cell, as a part of that of the template. HemoCell keeps volumes up to a per
/// mille; in a flat cell distances cannot be sampled.
constexpr double leastVolume = 0.01;

}  // namespace

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
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const Shape& shape = *problem.membranes[first + i].shape;
    const double ofTemplate = problem.species[meshes[i].species].shape->volume();
    if (shape.volume() >= leastVolume * ofTemplate) continue;
    const Vec3& at = meshes[i].cell->position;
    throw InputError(fmt::format(
        "{}: the mesh of a cell '{}' near ({:.6g}, {:.6g}, {:.6g}) µm is {}", file,
        problem.species[meshes[i].species].name, at[0], at[1], at[2],
        shape.volume() < 0.0
            ? "inside out"
            : fmt::format("flat: it has {:.4g} µm³, the template {:.4g}", shape.volume(), ofTemplate)));
  }
}

}  // namespace packmesh::hemocell
