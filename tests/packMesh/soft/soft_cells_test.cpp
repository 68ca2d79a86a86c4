// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/soft_cells.h"

#include "packMesh/certificate/certifier.h"
#include "packMesh/container/primitives.h"
#include "packMesh/core/pose.h"
#include "tests/packMesh/soft/soft_meshes.h"
#include "tests/support/catch.h"

namespace packmesh {
namespace {

std::vector<Vec3> placedAt(const TriangleMesh& mesh, double scale, const Vec3& at, double angle = 0.0) {
  return placedVertices(
      mesh, {scale * Quaternion::around(Vec3(1, 1, 0).normalized(), angle).toRotationMatrix(), at});
}

/// Violations of the exact test.
std::size_t faults(const SoftCells& cells, std::size_t count, const TriangleMesh& mesh,
                   const Container& lumen) {
  Physics physics;
  physics.container = std::shared_ptr<const Container>(&lumen, [](const Container*) {});
  const auto undeformed = std::make_shared<const Shape>(mesh);
  physics.add("cell", undeformed, std::int64_t(count));
  std::vector<PlacedCell> placed;
  for (std::size_t i = 0; i < count; ++i) {
    placed.push_back({0, std::int32_t(physics.shapes.size()), {}});
    physics.shapes.push_back(std::make_shared<const Shape>(cells.vertices(i), undeformed));
  }
  const Certificate found = certify(certificateInputOf(physics, placed));
  CHECK(found.complete);
  return found.overlapping.size() + found.misplaced.size() + found.selfIntersecting.size();
}

/// Eight cells in a periodic box that they will fill.
struct Crowd {
  TriangleMesh mesh = sample::redCell(2);
  std::shared_ptr<const Membrane> membrane = std::make_shared<const Membrane>(mesh, MembraneConstants());
  double side = std::cbrt(8.0 * membrane->volume() / 0.8);
  std::unique_ptr<Container> box = makeBox(Box{Vec3::Zero(), Vec3::Constant(side)}, {true, true, true});

  SoftCells cells(const SoftSettings& settings, int threads = 1, double scale = 0.5) const {
    std::vector<SoftCell> all;
    for (int n = 0; n < 8; ++n) {
      const Vec3 at = 0.25 * side * Vec3(1 + 2 * (n & 1), 1 + (n & 2), 1 + (n & 4) / 2);
      all.push_back({membrane, placedAt(mesh, scale, at, 0.4 * n), scale});
    }
    return {std::move(all), Vec3::Constant(side), {}, settings, Threads(threads)};
  }
};

TEST_CASE("no step lets membranes meet, whatever the forces", "[soft]") {
  const Crowd crowd;
  SoftSettings wild;
  wild.swelling = 0.02;  // faster than the membranes can follow
  wild.stiffness = 0.5;  // so weak that membranes are pressed together
  wild.mostCompressed = 1.0;
  SoftCells cells = crowd.cells(wild);
  for (int n = 0; n < 12; ++n) {
    for (int k = 0; k < 10; ++k) cells.step();
    CHECK(faults(cells, 8, crowd.mesh, *crowd.box) == 0);
  }
  CHECK(cells.smallestScale() == 1.0);
}

TEST_CASE("cells grow to full size and come to rest", "[soft]") {
  const Crowd crowd;
  SoftCells cells = crowd.cells({});
  while (cells.iterations() < 3000 && !(cells.full() && cells.usualForce() < 0.3)) cells.step();
  CHECK(cells.full());
  CHECK(cells.usualForce() < 0.3);
  CHECK(faults(cells, 8, crowd.mesh, *crowd.box) == 0);
  for (std::size_t i = 0; i < 8; ++i) {
    const Deformation d = deformationOf(*crowd.membrane, cells.vertices(i));
    CHECK(std::abs(d.volume) < 0.02);
    CHECK(std::abs(d.triangle) < 0.27);  // away from the pole of HemoCell's law
    CHECK(d.force < 10.0);
  }
}

TEST_CASE("the number of threads does not change a bit of soft cells", "[soft][threads]") {
  const Crowd crowd;
  SoftCells one = crowd.cells({}), four = crowd.cells({}, 4);
  for (int n = 0; n < 150; ++n) {
    one.step();
    four.step();
  }
  for (std::size_t i = 0; i < 8; ++i) CHECK(one.vertices(i) == four.vertices(i));
}

TEST_CASE("cells that touch nothing stay as they are", "[soft]") {
  const Crowd crowd;
  SoftCells cells({{crowd.membrane, placedAt(crowd.mesh, 1.0, Vec3(10, 10, 10)), 1.0},
                   {crowd.membrane, placedAt(crowd.mesh, 1.0, Vec3(30, 10, 10)), 1.0}},
                  Vec3::Zero(), {}, {}, {});
  const std::vector<Vec3> before = cells.vertices(1);
  for (int n = 0; n < 20; ++n) cells.step();
  CHECK(cells.full());
  const std::vector<Vec3> after = cells.vertices(1);
  for (std::size_t v = 0; v < before.size(); ++v) CHECK((after[v] - before[v]).norm() < 1e-4);
}

TEST_CASE("cells that nearly touch are pushed apart to the range of the barrier", "[soft]") {
  const TriangleMesh mesh = test::icosphere(3, 2.0);
  const auto membrane = std::make_shared<const Membrane>(mesh, MembraneConstants());
  for (const double gap : {1e-5, 1e-2}) {
    SoftCells cells({{membrane, placedAt(mesh, 1.0, Vec3(0, 0, 0)), 1.0},
                     {membrane, placedAt(mesh, 1.0, Vec3(4.0 + gap, 0, 0)), 1.0}},
                    Vec3::Zero(), {}, {}, {});
    for (int n = 0; n < 300; ++n) cells.step();
    double distance = 1e9;
    for (const Vec3& a : cells.vertices(0))
      for (const Vec3& b : cells.vertices(1)) distance = std::min(distance, (a - b).norm());
    CHECK(distance > 0.1);
  }
}

TEST_CASE("whether many cells are at rest does not depend on one in a hundred", "[soft]") {
  const TriangleMesh mesh = test::icosphere(1, 1.0);
  const auto membrane = std::make_shared<const Membrane>(mesh, MembraneConstants());
  const auto force = [&](int count, int stretched, int fixed) {
    std::vector<SoftCell> all;
    for (int n = 0; n < count; ++n) {
      const bool stays = n >= count - fixed;
      all.push_back(
          {membrane, placedAt(mesh, n < stretched || stays ? 1.1 : 1.0, Vec3(4 * n, 0, 0)), 1.0, stays});
    }
    SoftCells cells(std::move(all), Vec3::Zero(), {}, {}, {});
    cells.step();
    return cells.usualForce();
  };
  CHECK(force(99, 1, 0) > 1.0);
  CHECK(force(100, 1, 0) < 0.1);
  CHECK(force(100, 2, 0) > 1.0);
  CHECK(force(100, 1, 1) > 1.0);
  CHECK(force(100, 0, 10) < 0.1);
}

TEST_CASE("a contact moves and turns the whole cell at once", "[soft]") {
  const Crowd crowd;
  const TriangleMesh sphere = test::icosphere(3, 1.0);
  const std::vector<Vec3> before = placedAt(crowd.mesh, 1.0, Vec3::Zero());  // the axis along y
  double bottom = 0.0;
  for (const Vec3& v : before) bottom = std::min(bottom, v.y());
  const auto other = std::make_shared<const Membrane>(sphere, MembraneConstants());
  SoftCells cells(
      {{crowd.membrane, before, 1.0}, {other, placedAt(sphere, 1.0, Vec3(2.8, bottom - 1.02, 0)), 1.0, true}},
      Vec3::Zero(), {}, {}, {});
  cells.step();
  const std::vector<Vec3> after = cells.vertices(0);
  // No force acts on the other side, which was at rest: it moves as a rigid body does.
  double most = 0.0, mean = 0.0;  // [µm]
  std::vector<Vec3> there, moved;
  for (std::size_t v = 0; v < before.size(); ++v) {
    most = std::max(most, after[v].y() - before[v].y());
    mean += (after[v].y() - before[v].y()) / double(before.size());
    if (before[v].x() > -1.0) continue;
    there.push_back(before[v]);
    moved.push_back(after[v]);
  }
  const Pose pose = bestPose(there, moved);
  double deformed = 0.0;
  for (std::size_t v = 0; v < there.size(); ++v)
    deformed = std::max(deformed, (pose.placement()(there[v]) - moved[v]).norm());
  CHECK(most > 0.01);
  CHECK(mean > 0.3 * most);
  CHECK(pose.orientation.angularDistance(Quaternion::Identity()) > 0.1 * most);
  CHECK(deformed < 0.01 * most);
}

TEST_CASE("walls keep cells, and fixed cells keep their place", "[soft]") {
  const TriangleMesh mesh = test::icosphere(3, 2.0);
  const auto membrane = std::make_shared<const Membrane>(mesh, MembraneConstants());
  const auto tube = makeCylinder(Vec3(10, 0, 0), 0, 1.7, 20.0, false);
  const ClosedFormWall form = *tube->wall()->closedForm();
  const WallGap gap = [form](const Vec3& p) { return form.distance(p); };
  std::vector<SoftCell> all = {{membrane, placedAt(mesh, 0.7, Vec3(6, 0, 0)), 0.7, false, 0},
                               {membrane, placedAt(mesh, 0.7, Vec3(9, 0, 0)), 1.0, true, 0}};
  const std::vector<Vec3> fixed = all[1].vertices;
  SoftCells cells(std::move(all), Vec3::Zero(), {gap}, {}, {});
  for (int n = 0; n < 600; ++n) cells.step();
  CHECK(cells.smallestScale() == 1.0);
  CHECK(faults(cells, 2, mesh, *tube) == 0);
  const std::vector<Vec3> after = cells.vertices(1);
  for (std::size_t v = 0; v < fixed.size(); ++v) CHECK((after[v] - fixed[v]).norm() < 1e-6);
  double radius = 0.0, length = 0.0;
  for (const Vec3& v : cells.vertices(0)) {
    radius = std::max(radius, std::hypot(v.y(), v.z()));
    length = std::max(length, std::abs(v.x() - 6.0));
  }
  CHECK(radius < 1.7);
  CHECK(length > 2.05);  // what the wall takes from its width, it gains in length
}

}  // namespace
}  // namespace packmesh
