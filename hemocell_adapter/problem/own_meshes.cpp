// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/own_meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hemocell_adapter/base/setting_name.h"
#include "packMesh/core/error.h"
#include "packMesh/mesh/self_intersection_finder.h"

namespace packmesh::hemocell {
namespace {

/// Least volume of a deformed cell, as a part of that of the template. HemoCell keeps volumes up to a per
/// mille; in a flat cell distances cannot be sampled.
constexpr double leastVolume = 0.01;

std::string nearText(const PresentCell& cell) {
  return fmt::format("near ({:.6g}, {:.6g}, {:.6g}) µm", cell.position[0], cell.position[1],
                     cell.position[2]);
}

/// Those of the cells of a species that intersect themselves where they are.
std::vector<std::size_t> selfIntersecting(const Problem& problem, int species,
                                          const std::vector<const PresentCell*>& cells) {
  if (std::all_of(cells.begin(), cells.end(), [](const PresentCell* cell) { return cell->shape < 0; }))
    return {};
  const SelfIntersectionFinder finder(problem.species[species].shape->mesh());
  std::vector<char> meets(cells.size(), 0);
  problem.team.forEach(std::int64_t(cells.size()), [&](std::int64_t i, int) {
    if (cells[i]->shape < 0) return;
    const TriangleMesh& mesh = problem.shapes[cells[i]->shape]->mesh();
    meets[i] = bool(finder(placedVertices(mesh, placementOf(*cells[i]))));
  });
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (meets[i]) found.push_back(i);
  return found;
}

void undeform(Problem& problem, const std::vector<OwnMesh>& meshes, const std::string& file) {
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    std::vector<PresentCell*> cells;
    for (const OwnMesh& mesh : meshes)
      if (mesh.species == int(s)) cells.push_back(mesh.cell);
    if (cells.empty()) continue;
    const std::vector<std::size_t> found = selfIntersecting(problem, int(s), {cells.begin(), cells.end()});
    if (found.empty()) continue;
    for (const std::size_t i : found) cells[i]->shape = -1;
    problem.notices.push_back(fmt::format(
        "{}: {} of its {} cells '{}' with meshes of their own intersect{} {}, the first {}; {} the "
        "undeformed shape",
        file, found.size(), cells.size(), problem.species[s].name, found.size() == 1 ? "s" : "",
        found.size() == 1 ? "itself" : "themselves", nearText(*cells[found.front()]),
        found.size() == 1 ? "it gets" : "they get"));
  }
}

}  // namespace

void addOwnMeshes(Problem& problem, const std::vector<OwnMesh>& meshes, const std::string& file,
                  SelfIntersecting selfIntersecting) {
  for (const OwnMesh& mesh : meshes)
    if (problem.species[mesh.species].shape->mesh().triangles != *mesh.triangles)
      throw InputError(fmt::format(
          "{}: its cells '{}' have meshes of their own whose triangles are not those of the template", file,
          problem.species[mesh.species].name));
  const std::size_t first = problem.shapes.size();
  problem.shapes.resize(first + meshes.size());
  problem.team.forEach(std::int64_t(meshes.size()), [&](std::int64_t i, int) {
    PresentCell& cell = *meshes[i].cell;
    cell.shape = int(first + i);
    problem.shapes[first + i] = std::make_shared<const Shape>(std::exchange(cell.vertices, {}),
                                                              problem.species[meshes[i].species].shape);
  });
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const Shape& shape = *problem.shapes[first + i];
    const double ofTemplate = problem.species[meshes[i].species].shape->volume();
    if (shape.volume() >= leastVolume * ofTemplate) continue;
    throw InputError(fmt::format(
        "{}: the mesh of a cell '{}' {} is {}", file, problem.species[meshes[i].species].name,
        nearText(*meshes[i].cell),
        shape.volume() < 0.0
            ? "inside out"
            : fmt::format("flat: it has {:.4g} µm³, the template {:.4g}", shape.volume(), ofTemplate)));
  }
  if (selfIntersecting == SelfIntersecting::undeform) undeform(problem, meshes, file);
}

void refuseSelfIntersecting(const Problem& problem, const std::vector<PresentCell>& cells, int species,
                            const std::string& file) {
  std::vector<const PresentCell*> all;
  for (const PresentCell& cell : cells) all.push_back(&cell);
  const std::vector<std::size_t> found = selfIntersecting(problem, species, all);
  if (!found.empty())
    throw InputError(
        fmt::format("{}: {} of its {} cells '{}' intersect{} {}, the first is cell {} {}; fixed "
                    "cells stay as they are ({} gives such cells the undeformed shape)",
                    file, found.size(), all.size(), problem.species[species].name,
                    found.size() == 1 ? "s" : "", found.size() == 1 ? "itself" : "themselves",
                    found.front() + 1, nearText(cells[found.front()]), named("start")));
}

}  // namespace packmesh::hemocell
