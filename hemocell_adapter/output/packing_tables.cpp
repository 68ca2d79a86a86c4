// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/packing_tables.h"

#include <utility>

#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/deformation.h"
#include "packMesh/mesh/mesh_file.h"

namespace packmesh::hemocell {
namespace {

/// Sets the origin of a template in its file, or the reason why it has none: some programs simulate only
/// meshes of their own files.
void findInFile(const CellSpecies& species, PackingTables::Kind& kind) {
  if (species.kind != CellSpecies::Template::mesh) {
    kind.unlikeFile = "is not packed from a mesh file";
    return;
  }
  if (species.meshFrame != MeshFrame::file || species.meshScale != 1.0) {
    kind.unlikeFile = "is turned or scaled";
    return;
  }
  const TriangleMesh own = meshFrom(species.meshFile);
  const std::vector<Vec3>& packed = kind.mesh->vertices;
  const Vec3 origin = boundingBox(own).center();
  constexpr double rounding = 1e-9;  // of centring [µm]
  bool same = own.vertices.size() == packed.size();
  for (std::size_t i = 0; same && i < packed.size(); ++i)
    same = (own.vertices[i] - origin - packed[i]).cwiseAbs().maxCoeff() <= rounding;
  if (same)
    kind.originInFile = origin;
  else
    kind.unlikeFile = "has been repaired";
}

}  // namespace

PackingTables emptyTables(const Problem& problem, const std::vector<std::int64_t>& counts) {
  PackingTables tables;
  tables.lumen = problem.lumen.container.get();
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    const CellSpecies& species = problem.species[s];
    PackingTables::Kind kind{species.name, &species.shape->mesh(), counts[s], species.redCell};
    findInFile(species, kind);
    tables.kinds.push_back(std::move(kind));
  }
  return tables;
}

PackingTables tablesOf(const Packing& packing, const CellMeasures& measures) {
  const PackingResult& result = packing.result;
  PackingTables tables;
  together(packing.ranks(), [&] { tables = emptyTables(*packing.problem, packing.tally.counts); });
  CellColumn angles{"angles", 3, {}};
  for (std::size_t i = 0; i < result.cells.size(); ++i) {
    const PlacedCell& cell = result.cells[i];
    tables.kind.push_back(cell.species);
    if (packing.problem->hasDeformed())
      tables.vertices.push_back(packing.problem->isDeformed(cell)
                                    ? &packing.problem->shapes[cell.shape]->mesh().vertices
                                    : nullptr);
    const PosLine line = packing.problem->read->lineOf(result.poses[i]);
    tables.poses.push_back({1.0, result.poses[i].orientation, line.position});
    angles.values.insert(angles.values.end(), line.angles.data(), line.angles.data() + 3);
  }
  tables.columns = columnsOf(measures, result.cells.size());
  for (CellColumn& column : deformationColumns(*packing.problem, result.cells))
    tables.columns.push_back(std::move(column));
  tables.columns.push_back(std::move(angles));
  tables.certificate = &packing.result.certificate;
  return tables;
}

}  // namespace packmesh::hemocell
