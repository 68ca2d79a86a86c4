// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/membrane.h"

#include "packMesh/core/error.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/packMesh/soft/soft_meshes.h"
#include "tests/support/catch.h"

namespace packmesh {
namespace {

Vec3 sumOf(const std::vector<Vec3>& forces) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& f : forces) sum += f;
  return sum;
}

Vec3 torqueOf(const std::vector<Vec3>& at, const std::vector<Vec3>& forces) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t v = 0; v < at.size(); ++v) sum += at[v].cross(forces[v]);
  return sum;
}

double largestOf(const std::vector<Vec3>& forces) {
  double most = 0.0;
  for (const Vec3& f : forces) most = std::max(most, f.norm());
  return most;
}

/// Constants of a model with links through the cell.
MembraneConstants constantsOf(MembraneModel model) {
  MembraneConstants constants;
  constants.model = model;
  constants.innerLinks = {{0, 5}, {3, 11}, {7, 2}};
  constants.cytoskeleton = {0.5, 9.0};  // longer than the links: all push
  constants.core = {6.0, 2.0};
  return constants;
}

TEST_CASE("the forces of packing are the gradient of the energy", "[soft]") {
  const MembraneModel model =
      GENERATE(MembraneModel::highOrder, MembraneModel::platelet, MembraneModel::whiteCell);
  const Membrane membrane(sample::redCell(2), constantsOf(model));
  // Small, so that triangles are near their limits; and so much that some exceed them.
  for (const auto& [shake, scale] : {std::pair(0.05, 1.0), std::pair(0.03, 0.93), std::pair(0.25, 1.0)}) {
    const std::vector<Vec3> at = sample::shaken(membrane.mesh().vertices, shake, 5);
    std::vector<Vec3> forces;
    membraneEnergy(membrane, at, scale, &forces);
    for (std::size_t v = 0; v < at.size(); v += 7)
      for (int k = 0; k < 3; ++k) {
        constexpr double h = 1e-6;  // [µm]; rounding errors of the energy divided by it stay below 1e-5
        std::vector<Vec3> there = at;
        there[v][k] += h;
        const double above = membraneEnergy(membrane, there, scale);
        there[v][k] -= 2.0 * h;
        const double below = membraneEnergy(membrane, there, scale);
        CHECK(forces[v][k] == Approx((below - above) / (2.0 * h)).epsilon(2e-4).margin(2e-4));
      }
  }
}

TEST_CASE("a membrane at rest has no energy, at any scale", "[soft]") {
  const Membrane membrane(sample::redCell(2), {});
  std::vector<Vec3> small = membrane.mesh().vertices, forces;
  CHECK(membraneEnergy(membrane, small, 1.0, &forces) < 1e-6);
  CHECK(largestOf(forces) < 1e-4);  // rest lengths are in single precision
  CHECK(largestOf(hemocellForces(membrane, small)) < 1e-9);
  for (Vec3& v : small) v *= 0.6;
  forces.clear();
  CHECK(membraneEnergy(membrane, small, 0.6, &forces) < 1e-6);
  CHECK(largestOf(forces) < 1e-4);
  CHECK(membraneEnergy(membrane, small, 1.0) > 1.0);
}

TEST_CASE("energy and forces are the same wherever a cell is, and forces sum to nothing", "[soft]") {
  const Membrane membrane(sample::redCell(2), {});
  const std::vector<Vec3> at = sample::shaken(membrane.mesh().vertices, 0.05, 9);
  std::vector<Vec3> forces, moved, forcesThere;
  const double energy = membraneEnergy(membrane, at, 1.0, &forces);
  const Mat3 turn = Quaternion::around(Vec3(1, 2, -1).normalized(), 0.7).toRotationMatrix();
  for (const Vec3& v : at) moved.push_back(turn * v + Vec3(3, -5, 11));
  CHECK(membraneEnergy(membrane, moved, 1.0, &forcesThere) == Approx(energy).epsilon(1e-10));
  const double unit = largestOf(forces);
  REQUIRE(unit > 1.0);
  for (std::size_t v = 0; v < at.size(); ++v) CHECK((forcesThere[v] - turn * forces[v]).norm() < 1e-8 * unit);
  CHECK(sumOf(forces).norm() < 1e-8 * unit);
  CHECK(torqueOf(at, forces).norm() < 1e-7 * unit);
  // HemoCell's own bending has a torque, which packing must not have.
  const std::vector<Vec3> hemocell = hemocellForces(membrane, at);
  CHECK(sumOf(hemocell).norm() < 1e-8 * unit);
  CHECK(torqueOf(at, hemocell).norm() > 1e-3);
}

TEST_CASE("forces of HemoCell's laws on a stretched tetrahedron, computed by hand", "[soft]") {
  TriangleMesh mesh;
  mesh.vertices = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  REQUIRE(signedVolume(mesh) > 0.0);
  MembraneConstants constants;
  constants.spacing = 0.25;
  const Membrane membrane(mesh, constants);
  std::vector<Vec3> at = mesh.vertices;
  for (Vec3& v : at) v *= 1.1;
  // All strains follow from the factor 1.1; the edge is √8, the height of a vertex over the middle of the
  // others √(2/3) of it, and HemoCell's constants are those of cellMechanics.h.
  const auto law = [](double limit, double x) { return x + x / std::abs(limit - x * x); };
  const double kT = 4.100531391e-3, edge = std::sqrt(8.0), height = std::sqrt(2.0 / 3.0);
  const double link = 15.0 * kT / 7.5e-3 * law(9.0, 0.1) * 3.0 * height;
  const double area = 5.0 * (1280.0 / 4.0) * kT / 0.5 / 0.25 * law(0.09, 0.21) * 2.0 * height * 1.1 * edge;
  const double strain = 0.331;
  const double volume = 20.0 * (1280.0 / 4.0) * kT / 0.5 * strain / std::abs(0.01 - strain * strain) * 1.21;
  // The deviation of the middle of the neighbours is -height, by 0.1 height more.
  const double bending = 80.0 * kT / 0.5 * law(0.0555, 0.1 * height) * 4.0 / 3.0;
  for (const auto& [v, force] : {std::pair(0, hemocellForces(membrane, at)[0])}) {
    const Vec3 outward = at[v].normalized();
    CHECK(force.dot(outward) == Approx(-link - area - volume - bending).epsilon(1e-6));
    CHECK(force.cross(outward).norm() < 1e-9);
  }
}

TEST_CASE("platelets and white cells have links through the cell, of which those of the latter push",
          "[soft]") {
  TriangleMesh mesh;
  mesh.vertices = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  const auto forceOf = [&](MembraneModel model, bool linked, double stretch) {
    MembraneConstants constants;
    constants.bend = 0.0;
    constants.model = model;
    if (linked) constants.innerLinks = {{0, 2}};
    constants.cytoskeleton = {0.5, 1.5};
    constants.core = {6.0, 1.45};
    std::vector<Vec3> at = mesh.vertices;
    for (Vec3& v : at) v *= stretch;
    return hemocellForces(Membrane(mesh, constants), at)[0];
  };
  const Vec3 along = Vec3(-1, 0, -1).normalized();
  const auto ofLink = [&](MembraneModel model, double stretch) {
    const Vec3 force = forceOf(model, true, stretch) - forceOf(model, false, stretch);
    CHECK(force.cross(along).norm() < 1e-12);
    return force.dot(along);
  };
  // pltSimpleModel.cpp: linear, five times as stiff as the links of edges.
  CHECK(ofLink(MembraneModel::platelet, 1.1) ==
        Approx(5.0 * 25.0 / 25.0 * 15.0 * 4.100531391e-3 / 7.5e-3 * 0.1));
  CHECK(ofLink(MembraneModel::platelet, 0.9) < -0.1);
  // wbcHighOrderModel.cpp: each up to twice its radius.
  const double edge = std::sqrt(8.0);
  CHECK(ofLink(MembraneModel::whiteCell, 1.0) == Approx(-0.5 * (1 - edge / 3.0) - 6.0 * (1 - edge / 2.9)));
  CHECK(ofLink(MembraneModel::whiteCell, 1.04) == Approx(-0.5 * (1 - 1.04 * edge / 3.0)));
  CHECK(ofLink(MembraneModel::whiteCell, 1.1) == 0.0);
  CHECK(ofLink(MembraneModel::highOrder, 1.1) == 0.0);
  MembraneConstants outside = constantsOf(MembraneModel::platelet);
  CHECK_THROWS_WITH(Membrane(mesh, outside), Contains("an inner link between the vertices 0 and 5, of 4"));
}

TEST_CASE("a deformation states the largest changes", "[soft]") {
  const Membrane membrane(test::icosphere(2, 2.0), {});
  std::vector<Vec3> larger = membrane.mesh().vertices;
  for (Vec3& v : larger) v *= 1.01;
  const Deformation d = deformationOf(membrane, larger);
  CHECK(d.volume == Approx(0.030301));
  CHECK(d.area == Approx(0.0201));
  CHECK(d.triangle == Approx(0.0201));
  CHECK(d.edge == Approx(0.01));
  CHECK(d.force == Approx(largestOf(hemocellForces(membrane, larger))));
  for (Vec3& v : larger) v *= 0.9;
  CHECK(deformationOf(membrane, larger).edge == Approx(0.909 - 1.0));
}

TEST_CASE("surfaces that are open, or have too many triangles, are no membranes", "[soft]") {
  TriangleMesh open = test::icosphere(1);
  open.triangles.pop_back();
  CHECK_THROWS_AS(Membrane(open, {}), InputError);
  CHECK_THROWS_WITH(Membrane(sample::sphere(Vec3::Zero(), 1.0, 130, 130), {}), Contains("at most 32767"));
}

}  // namespace
}  // namespace packmesh
