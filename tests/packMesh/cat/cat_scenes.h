// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Arrangements of objects for tests of tetrahedra and CAT cells.
#pragma once

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "packMesh/cat/tetrahedra.h"
#include "tests/support/packings.h"

namespace packmesh::test {

/// Input with what it refers to.
struct CatScene {
  std::vector<std::shared_ptr<const void>> owned;
  std::shared_ptr<const Container> lumen;  ///< where there is one
  TetrahedraInput input;

  const MeshHierarchy* own(const TriangleMesh& mesh) {
    const auto hierarchy = std::make_shared<const MeshHierarchy>(mesh);
    owned.push_back(hierarchy);
    return hierarchy.get();
  }
  double objectVolume() const {
    double sum = 0.0;
    for (const PlacedMesh& object : input.objects)
      sum += signedVolume(object.mesh->mesh()) * object.placement.linear.determinant();
    return sum;
  }
  double containerVolume() const { return signedVolume(input.container->mesh()); }
};

/// Cells of pack(), free of overlap; with `scale` shrunk about their centres.
inline CatScene packedScene(const PackingProblem& problem, double scale = 1.0) {
  CatScene scene;
  scene.lumen = problem.physics.container;
  scene.owned.assign(problem.physics.shapes.begin(), problem.physics.shapes.end());
  for (const PlacedCell& cell : pack(problem).cells) {
    Placement placement = cell.placement;
    placement.linear *= scale;
    scene.input.objects.push_back({&problem.physics.shapeOf(cell).hierarchy(), placement});
  }
  if (problem.physics.container->wall())
    scene.input.container = scene.own(problem.physics.container->surface());
  scene.input.period = problem.physics.container->period();
  scene.input.bounds = problem.physics.container->bounds();
  return scene;
}

/// Red cells in a sphere at a volume fraction.
inline CatScene redCellsInSphere(int count, double fraction, double scale = 1.0) {
  PackingProblem problem;
  const double volume = count * redCellShape()->volume() / fraction;
  problem.physics.container = makeSphere(Vec3(1.0, -2.0, 3.0), std::cbrt(0.75 * volume / M_PI));
  problem.physics.add("RBC", redCellShape(), count);
  return packedScene(problem, scale);
}

inline CatScene redCellsInPeriodicBox(double edge, double fraction, double scale = 1.0) {
  return packedScene(redCellProblem(periodicCube(edge), fraction), scale);
}

inline CatScene redCellsInPeriodicCylinder(double fraction, double scale = 1.0) {
  return packedScene(redCellProblem(makeCylinder(Vec3::Zero(), 0, 6.5, 20.0, true), fraction), scale);
}

/// The same red cells with fewer vertices (42 for level 1, 162 for level 2), shrunk so that they do not meet.
inline CatScene coarse(CatScene scene, int level, double scale) {
  const Mat3 toThinY = Quaternion::around(Vec3::UnitX(), 0.5 * M_PI).toRotationMatrix();
  const MeshHierarchy* cell = scene.own(redCell(level));
  for (PlacedMesh& object : scene.input.objects)
    object = {cell, {scale * object.placement.linear * toThinY, object.placement.translation}};
  return scene;
}

/// Thesis figure 4.1: four cubes in a flat cuboid. They stand in a square, so that no tetrahedra are in
/// general position.
inline CatScene fourCubes() {
  CatScene scene;
  scene.input.container = scene.own(sample::voxels(8, 0.5, [](int, int, int z) { return z < 2; }));
  const MeshHierarchy* cube = scene.own(sample::box(Vec3::Constant(-0.25), Vec3::Constant(0.25)));
  for (const double x : {1.0, 3.0})
    for (const double y : {1.0, 3.0}) scene.input.objects.push_back({cube, {Mat3::Identity(), {x, y, 0.5}}});
  return scene;
}

/// Thesis figure 4.2: four spheres and two cubes in a sphere.
inline CatScene spheresAndCubes() {
  CatScene scene;
  std::mt19937 random(42);
  scene.input.container = scene.own(icosphere(3, 4.0));
  const MeshHierarchy* ball = scene.own(sample::sphere(Vec3::Zero(), 1.0, 13, 21));  // 254 vertices
  const MeshHierarchy* cube = scene.own(sample::box(Vec3::Constant(-0.7), Vec3::Constant(0.7)));
  for (int k = 0; k < 3; ++k)
    for (const double side : {-1.0, 1.0})
      scene.input.objects.push_back(
          {k == 2 ? cube : ball, {randomRotation(random), 2.2 * side * Vec3::Unit(k)}});
  return scene;
}

/// Bodies of all kinds: with a hole, non-convex, of very different sizes.
inline CatScene mixture() {
  CatScene scene;
  std::mt19937 random(7);
  scene.input.container = scene.own(sample::box(Vec3(-6, -5, -4), Vec3(6, 5, 4)));
  const MeshHierarchy* ring = scene.own(sample::torus(Vec3::Zero(), 1.5, 0.5, 24, 12));
  const MeshHierarchy* hook = scene.own(hookMesh());
  const MeshHierarchy* bumpy = scene.own(bumpyMesh(5));
  const MeshHierarchy* cube = scene.own(sample::box(Vec3::Constant(-1.0), Vec3::Constant(1.0)));
  const auto add = [&](const MeshHierarchy* mesh, double scale, const Vec3& at) {
    scene.input.objects.push_back({mesh, {scale * randomRotation(random), at}});
  };
  add(ring, 1.0, {-3.5, -2.5, 0.0});
  add(hook, 0.5, {-3.0, 2.5, 1.0});
  add(bumpy, 0.9, {2.5, 2.0, 0.0});
  add(cube, 0.3, {2.5, -2.0, 2.0});
  add(cube, 0.03, {0.0, 0.0, 0.0});
  add(ring, 0.8, {2.0, -2.5, -1.0});
  return scene;
}

inline double volumeOf(const Tetrahedra& t, int index) {
  const Vec3& a = t.corner(index, 0);
  return (t.corner(index, 1) - a).cross(t.corner(index, 2) - a).dot(t.corner(index, 3) - a) / 6.0;
}

}  // namespace packmesh::test
