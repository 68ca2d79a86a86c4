// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Meshes of soft cells for tests, and the engine that packs them.
#pragma once

#include "packMesh/soft/soft_engine.h"
#include "tests/packMesh/mesh/test_meshes.h"

namespace packmesh::sample {

/// A red cell with its axis along y [µm].
inline TriangleMesh redCell(int levels) {
  TriangleMesh mesh = test::redCell(levels);
  for (Vec3& v : mesh.vertices) v = Vec3(v.y(), v.z(), v.x());
  return mesh;
}

/// Every vertex displaced by up to `most` along each axis.
inline std::vector<Vec3> shaken(std::vector<Vec3> vertices, double most, unsigned seed) {
  std::mt19937 random(seed);
  for (Vec3& v : vertices)
    for (int k = 0; k < 3; ++k) v[k] += most * (2.0 * double(random()) / double(random.max()) - 1.0);
  return vertices;
}

/// The engine of a problem, of whose species all cells are soft unless membranes are given.
inline std::shared_ptr<const SoftEngine> softEngine(const PackingProblem& problem,
                                                    const SoftLimits& limits = {},
                                                    std::vector<SoftSpecies> species = {}) {
  auto engine = std::make_shared<SoftEngine>();
  engine->species = std::move(species);
  engine->species.resize(problem.physics.species.size());
  engine->limits = limits;
  return engine;
}

/// Of a packing by that engine.
inline const SoftStatistics& reachedBy(const PackingResult& packed) {
  return dynamic_cast<const SoftStatistics&>(
      *(packed.deformed ? packed.deformed->engine : packed.statistics.engine));
}

}  // namespace packmesh::sample
