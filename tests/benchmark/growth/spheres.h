// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Red cells in spheres, as tetrahedra and growth get them.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "hemocell_adapter/hemocell/cell_model.h"
#include "packMesh/cat/tetrahedra.h"
#include "packMesh/container/primitives.h"
#include "packMesh/packing/pack.h"
#include "tests/benchmark/growth/cases.h"

namespace packmesh::benchmark {

/// Red cells at full detail in a sphere, as in thesis 4.2: 30 % of its volume when grown.
struct Spheres {
  std::shared_ptr<const Shape> shape = hemocell::makeShape(*hemocell::defaultModel("RBC"), 0.5);
  PackingProblem problem;
  std::vector<Pose> poses;  ///< at `scale`
  std::unique_ptr<MeshHierarchy> wall;
  TetrahedraInput input;

  Spheres(int count, double scale) {
    problem.physics.container =
        makeSphere(Vec3::Zero(), std::cbrt(0.75 * count * shape->volume() / (0.3 * M_PI)));
    problem.physics.add("RBC", shape, count);
    wall = std::make_unique<MeshHierarchy>(problem.physics.container->surface());
    poses = pack(problem).poses;
    for (Pose& pose : poses) {
      pose.scale = scale;
      input.objects.push_back({&shape->hierarchy(), pose.placement()});
    }
    input.container = wall.get();
    input.kept = TetrahedraKept::joining;
    input.valid = true;
  }
  std::size_t vertices() const { return input.objects.size() * shape->mesh().vertices.size(); }
};

/// CPU time of one plain `tetgen -p` run [s]: TetGen's own program does just this between reading and writing
/// files.
double plainTetgenSeconds(const TetrahedraInput& input);

}  // namespace packmesh::benchmark
