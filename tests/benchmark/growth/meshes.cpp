// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Single objects in thin copies of themselves (thesis figure 4.3), and other closed meshes in a
/// sphere.
#include <cmath>

#include "packMesh/container/vessel.h"
#include "tests/benchmark/growth/packings.h"
#include "tests/support/bodies.h"

namespace packmesh::benchmark {
namespace {

/// One object in a copy of itself of which it fills 0.8.
PackingProblem inItself(const TriangleMesh& mesh) {
  TriangleMesh around = mesh;
  for (Vec3& v : around.vertices) v *= std::cbrt(1.0 / 0.8);
  return grown(std::make_shared<const Shape>(mesh), 1, makeVessel(std::move(around), {}, 0.2));
}

PackingProblem inSphere(const TriangleMesh& mesh, int count, double fraction) {
  const auto shape = std::make_shared<const Shape>(mesh);
  return grown(shape, count, sphereFor(*shape, count, fraction));
}

const AddCases cases({
    packings("itself", "one object in a copy of itself of which it fills 0.8 (thesis figure 4.3)",
             {{"cube", [] { return inItself(test::cube(4.0)); }, 1.0},
              {"sphere", [] { return inItself(test::icosphere(3, 2.5)); }, 1.0},
              {"tetrahedron", [] { return inItself(test::tetrahedron()); }, 1.0},
              {"cone", [] { return inItself(test::cone()); }, 1.0}}),
    packings("any-mesh", "20 objects of any closed mesh in a sphere, coverage 0.20",
             {{"torus", [] { return inSphere(sample::torus(Vec3::Zero(), 3.0, 1.0, 40, 20), 20, 0.20); }},
              {"star", [] { return inSphere(test::star(), 20, 0.20); }},
              {"organic", [] { return inSphere(test::organic(), 20, 0.20); }}}),
});

}  // namespace
}  // namespace packmesh::benchmark
