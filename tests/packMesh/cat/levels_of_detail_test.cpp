// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/levels_of_detail.h"

#include "packMesh/mesh/mesh_repair.h"
#include "packMesh/mesh/self_intersection.h"
#include "tests/support/catch.h"
#include "tests/support/shapes.h"

using namespace packmesh;

namespace {

/// Each edge is used once in either direction.
bool closed(const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> uses;
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) ++uses[{t[k], t[(k + 1) % 3]}];
  for (const auto& [edge, n] : uses)
    if (n != 1 || uses.count({edge.second, edge.first}) == 0) return false;
  return !mesh.triangles.empty();
}

std::set<std::array<double, 3>> points(const TriangleMesh& mesh) {
  std::set<std::array<double, 3>> out;
  for (const Vec3& v : mesh.vertices) out.insert({v.x(), v.y(), v.z()});
  return out;
}

bool subset(const TriangleMesh& coarse, const TriangleMesh& fine) {
  const auto all = points(fine);
  for (const auto& p : points(coarse))
    if (all.count(p) == 0) return false;
  return true;
}

}  // namespace

TEST_CASE("The resampling factor increases from alpha to 1") {
  CHECK(resamplingFactor(1.0, 0.05, 0.1) == Approx(1.0));
  CHECK(resamplingFactor(0.0, 0.05, 0.1) == Approx(0.05).epsilon(1e-6));
  CHECK(resamplingFactor(1.0, 0.25, 0.5) == Approx(1.0));
  double last = 0.0;
  for (double k = 0.0; k <= 1.0; k += 0.05) {
    const double now = resamplingFactor(k, 0.25, 0.5);
    CHECK(now > last);
    last = now;
  }
}

TEST_CASE("Refined meshes are recognised, others are not") {
  for (int level = 1; level <= 4; ++level) {
    const std::optional<TriangleMesh> coarse = unrefined(test::icosphere(level));
    REQUIRE(coarse);
    CHECK(coarse->triangles.size() == test::icosphere(level - 1).triangles.size());
    CHECK(points(*coarse) == points(test::icosphere(level - 1)));
    CHECK(closed(*coarse));
    CHECK(signedVolume(*coarse) > 0.0);
  }
  CHECK(!unrefined(test::icosphere(0)));
  CHECK(!unrefined(sample::box(Vec3::Zero(), Vec3::Ones())));
  CHECK(!unrefined(sample::sphere(Vec3::Zero(), 1.0, 12, 16)));
  TriangleMesh cut = test::icosphere(2);
  cut.triangles.pop_back();
  CHECK(!unrefined(cut));
}

TEST_CASE("HemoCell's red cell has nested levels") {
  const TriangleMesh& fine = test::redCellShape()->mesh();
  const LevelsOfDetail levels(fine);
  REQUIRE(levels.count() == 3);
  CHECK(levels.mesh(0).vertices.size() == 642);
  CHECK(levels.mesh(1).vertices.size() == 162);
  CHECK(levels.mesh(2).vertices.size() == 42);
  CHECK(levels.indexOf(1.0) == 0);
  CHECK(levels.indexOf(0.25) == 1);
  CHECK(levels.indexOf(0.0) == 2);
  CHECK(&levels.level(0.6) == &levels.mesh(0));
  for (int k = 1; k < 3; ++k) CHECK(subset(levels.mesh(k), fine));
}

TEST_CASE("Any closed mesh has levels that are closed and do not intersect themselves") {
  for (const TriangleMesh& mesh : {sample::torus(Vec3::Zero(), 3.0, 1.0, 48, 24), test::bumpyMesh(5),
                                   test::hookMesh(), sample::sphere(Vec3::Zero(), 2.0, 20, 30)}) {
    const LevelsOfDetail levels(mesh);
    CHECK(levels.count() >= 2);
    for (int k = 0; k < levels.count(); ++k) {
      const TriangleMesh& level = levels.mesh(k);
      CHECK(closed(level));
      CHECK(!findSelfIntersection(level));
      CHECK(signedVolume(level) > 0.5 * signedVolume(mesh));
      CHECK(subset(level, mesh));
      if (k > 0) CHECK(2 * level.vertices.size() < levels.mesh(k - 1).vertices.size());
    }
  }
  CHECK(LevelsOfDetail(sample::box(Vec3::Zero(), Vec3::Ones())).count() == 1);
}
