// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/packing_tables.h"

#include <utility>

#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/deformation.h"
#include "packMesh/mesh/mesh_file.h"

namespace packmesh::hemocell {
namespace {

/// Some programs simulate only meshes of their own files.
TemplateSource sourceOf(const CellSpecies& species) {
  if (species.kind != CellSpecies::Template::mesh) return {{}, "is not packed from a mesh file"};
  if (species.meshFrame != MeshFrame::file || species.meshScale != 1.0) return {{}, "is turned or scaled"};
  const TriangleMesh own = meshFrom(species.meshFile);
  const std::vector<Vec3>& packed = species.shape->mesh().vertices;
  const Vec3 origin = boundingBox(own).center();
  constexpr double rounding = 1e-9;  // of centring [µm]
  bool same = own.vertices.size() == packed.size();
  for (std::size_t i = 0; same && i < packed.size(); ++i)
    same = (own.vertices[i] - origin - packed[i]).cwiseAbs().maxCoeff() <= rounding;
  if (!same) return {{}, "has been repaired"};
  return {origin, {}};
}

PackingDetails detailsOf(const Problem& problem) {
  PackingDetails details;
  details.lumen = true;
  for (const CellSpecies& species : problem.species) details.templates.push_back(sourceOf(species));
  return details;
}

Physics physicsOf(const Problem& problem, const std::vector<std::int64_t>& counts) {
  Physics physics = physicsOf(problem);
  for (std::size_t s = 0; s < counts.size(); ++s) physics.species[s].count = counts[s];
  return physics;
}

}  // namespace

std::unique_ptr<AtomicFiles> writtenWithoutCells(const std::filesystem::path& file, const Problem& problem,
                                                 const std::vector<std::int64_t>& counts) {
  return writtenPacking(file, physicsOf(problem, counts), {}, detailsOf(problem), {});
}

std::unique_ptr<AtomicFiles> writtenTables(const std::filesystem::path& file, const Packing& packing,
                                           const CellMeasures& measures) {
  const Problem& problem = *packing.problem;
  PackingDetails details;
  together(packing.ranks(), [&] { details = detailsOf(problem); });
  CellColumn angles{"angles", 3, {}};
  for (const Pose& pose : packing.poses) {
    const PosLine line = problem.read->lineOf(pose);
    angles.values.insert(angles.values.end(), line.angles.data(), line.angles.data() + 3);
  }
  details.columns = columnsOf(measures, packing.cells.size());
  for (CellColumn& column : deformationColumns(problem, packing.cells))
    details.columns.push_back(std::move(column));
  details.columns.push_back(std::move(angles));
  return writtenPacking(file, physicsOf(problem, packing.tally.counts), packing, details, packing.ranks());
}

}  // namespace packmesh::hemocell
