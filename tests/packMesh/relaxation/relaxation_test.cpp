// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/relaxation.h"

#include "packMesh/core/tolerances.h"
#include "packMesh/placement/placement.h"
#include "packMesh/relaxation/schedule.h"
#include "tests/support/catch.h"
#include "tests/support/physics.h"
#include "tests/support/shapes.h"

using namespace packmesh;

namespace {

Box cube(double edge) {
  return {Vec3::Zero(), Vec3::Constant(edge)};
}

/// Shapes in a periodic box.
Physics physicsIn(const Box& bounds, const std::vector<std::shared_ptr<const Shape>>& shapes) {
  return test::physicsOf(shapes, makeBox(bounds, {true, true, true}));
}

Body bodyAt(const Vec3& position, std::int64_t id, int species = 0) {
  Body b;
  b.position = position;
  b.id = id;
  b.species = b.shape = species;
  return b;
}

std::vector<Body> randomBodies(Physics physics, int count, std::uint64_t seed) {
  physics.seed = seed;
  std::vector<Body> bodies;
  for (const Pose& pose : placeRandomly(physics, {}, 0, 0, 0, count)) {
    Body b = bodyAt(pose.position, std::int64_t(bodies.size()));
    b.orientation = pose.orientation;
    b.rotation = pose.orientation.toRotationMatrix();
    bodies.push_back(b);
  }
  return bodies;
}

bool sameState(const std::vector<Body>& a, const std::vector<Body>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Body& x, const Body& y) {
    return x.id == y.id && x.position == y.position && x.orientation.coeffs() == y.orientation.coeffs() &&
           x.moved == y.moved;
  });
}

}  // namespace

TEST_CASE("Two overlapping spheres separate along the line of their centres, to the clearance",
          "[relaxation]") {
  const auto sphere = test::sphereShape(1.0);
  for (const double clearance : {0.02, 0.25}) {
    Physics physics = physicsIn(cube(20.0), {sphere});
    physics.clearance = clearance - tolerance::relaxationMargin;
    const Vec3 direction = Vec3(1.0, 2.0, -0.5).normalized(), middle(10.0, 9.0, 11.0);
    Relaxation relaxation(physics, {},
                          {bodyAt(middle - 0.8 * direction, 0), bodyAt(middle + 0.8 * direction, 1)});
    for (int k = 0; k < 60; ++k) relaxation.sweep(0.4);
    const std::vector<Body> cells = relaxation.cells();
    const Vec3 apart = cells[1].position - cells[0].position;
    REQUIRE(apart.norm() == Approx(2.0 + clearance).margin(0.012));
    REQUIRE(apart.normalized().dot(direction) > 0.9995);
    // Equal masses: the middle stays.
    REQUIRE((0.5 * (cells[0].position + cells[1].position) - middle).norm() < 1e-9);
    REQUIRE(relaxation.lastSweep().deepest < 1e-4);
  }
}

TEST_CASE("Cells separate across a periodic face as they do inside", "[relaxation]") {
  const auto shape = test::redCellShape();
  const Box bounds = cube(30.0);
  const auto run = [&](const Vec3& at) {
    Body a = bodyAt(wrapped(at, bounds, bounds.size()), 0);
    Body b = bodyAt(wrapped(at + Vec3(3.0, 1.0, 0.5), bounds, bounds.size()), 1);
    Relaxation relaxation(physicsIn(bounds, {shape}), {}, {a, b});
    for (int k = 0; k < 50; ++k) relaxation.sweep(1.0);
    const std::vector<Body> cells = relaxation.cells();
    Vec3 apart = cells[1].position - cells[0].position;
    for (int k = 0; k < 3; ++k) apart[k] -= 30.0 * std::round(apart[k] / 30.0);
    return apart;
  };
  const Vec3 inside = run(Vec3::Constant(14.0));
  REQUIRE(inside.norm() > 3.3);
  REQUIRE((run(Vec3(29.0, 29.5, 29.9)) - inside).norm() < 1e-4);
  REQUIRE((run(Vec3(29.0, 14.0, 14.0)) - inside).norm() < 1e-4);
}

TEST_CASE("The heavier cell moves less", "[relaxation]") {
  const auto heavy = test::sphereShape(2.0), light = test::sphereShape(1.0);
  Relaxation relaxation(physicsIn(cube(20.0), {heavy, light}), {},
                        {bodyAt(Vec3(10.0, 10.0, 10.0), 0, 0), bodyAt(Vec3(12.0, 10.0, 10.0), 1, 1)});
  for (int k = 0; k < 60; ++k) relaxation.sweep(0.4);
  const std::vector<Body> cells = relaxation.cells();
  const double heavyMoved = 10.0 - cells[0].position.x(), lightMoved = cells[1].position.x() - 12.0;
  REQUIRE(heavyMoved + lightMoved == Approx(1.02).margin(0.012));
  REQUIRE(lightMoved > 5.0 * heavyMoved);
  REQUIRE(heavyMoved > 0.0);
}

TEST_CASE("Relaxation depends on the seed, not on the order of the cells", "[relaxation]") {
  const auto shape = test::redCellShape();
  const Box bounds = cube(25.0);
  const auto run = [&](std::uint64_t seed, bool reversed) {
    const Physics physics = physicsIn(bounds, {shape});
    std::vector<Body> bodies = randomBodies(physics, 80, seed);
    if (reversed) std::reverse(bodies.begin(), bodies.end());
    Relaxation relaxation(physics, {}, std::move(bodies));
    for (int k = 0; k < 12; ++k) relaxation.sweep(1.0);
    return relaxation.cells();
  };
  const std::vector<Body> first = run(1, false);
  REQUIRE(sameState(run(1, false), first));
  REQUIRE(sameState(run(1, true), first));
  REQUIRE_FALSE(sameState(run(2, false), first));
}

TEST_CASE("Any number of threads gives the same result", "[relaxation]") {
  const Physics physics = physicsIn(cube(35.0), {test::redCellShape()});  // a single block
  const auto run = [&](const Threads& threads) {
    Execution execution;
    execution.threads = threads;
    Relaxation relaxation(physics, execution, randomBodies(physics, 290, 1));
    REQUIRE(relaxation.blockCount() == 1);
    for (int k = 0; k < 40; ++k) relaxation.sweep(1.0);
    return relaxation.cells();
  };
  const std::vector<Body> alone = run(Threads());
  for (const int threads : {2, 4, 8}) {
    CAPTURE(threads);
    REQUIRE(sameState(run(Threads(threads)), alone));
  }
}

TEST_CASE("Penetrations decrease, and vanish at a fraction of 0.4", "[relaxation]") {
  const auto shape = test::redCellShape();
  const Box bounds = cube(25.0);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    CAPTURE(seed);
    const Physics physics = physicsIn(bounds, {shape});
    Relaxation relaxation(physics, {}, randomBodies(physics, 77, seed));
    const double start = relaxation.sweep(1.0).total();
    double before = start;
    for (int k = 0; k < 5; ++k) {
      for (int sweep = 0; sweep < 8; ++sweep) relaxation.sweep(1.0);
      const double now = relaxation.lastSweep().total();
      REQUIRE(now <= before);
      before = now;
    }
    REQUIRE(before < 0.01 * start);
    ScheduleLimits limits;
    limits.maxSweeps = 2000;
    REQUIRE(relax(relaxation, limits));
    REQUIRE(relaxation.lastSweep().deepest <= 0.01);
    REQUIRE(relaxation.sweeps() < 400);
    REQUIRE(relaxation.cells().size() == 77);
    for (const Body& b : relaxation.cells()) {
      REQUIRE((b.position.array() >= bounds.lo.array()).all());
      REQUIRE((b.position.array() < bounds.hi.array()).all());
      REQUIRE(b.orientation.norm() == Approx(1.0));
      REQUIRE(b.rotation.isApprox(b.orientation.toRotationMatrix()));
    }
  }
}

TEST_CASE("Walls push cells into the lumen", "[relaxation]") {
  const auto shape = test::redCellShape();
  std::vector<std::shared_ptr<const Container>> containers;
  containers.push_back(makeBox(cube(22.0), {false, false, false}));
  containers.push_back(makeSphere(Vec3(3.0, -2.0, 1.0), 12.0));
  containers.push_back(makeCylinder(Vec3(0.0, 5.0, 0.0), 1, 8.0, 20.0, false));
  for (const auto& container : containers) {
    CAPTURE(container->describe());
    Physics physics = test::physicsOf({shape}, container);
    physics.wallClearance = 0.08;
    const int count = int(0.15 * container->volume() / shape->volume());
    std::vector<Body> bodies = randomBodies(physics, count, 1);
    for (std::size_t i = 0; i < bodies.size(); i += 3)  // through the wall
      bodies[i].position += 1.5 * (bodies[i].position - container->bounds().center()).normalized();
    Relaxation relaxation(physics, {}, std::move(bodies));
    ScheduleLimits limits;
    limits.maxSweeps = 3000;
    REQUIRE(relax(relaxation, limits));
    for (const Body& b : relaxation.cells())
      for (const Vec3& v : shape->mesh().vertices)
        REQUIRE(container->wall()->distance(b.position + b.rotation * v).distance > 0.085);
  }
}

TEST_CASE("Cells outside of the lumen are held next to its bounds, and come back", "[relaxation]") {
  const auto sphere = test::sphereShape(1.0);
  const std::shared_ptr<const Container> container = makeCylinder(Vec3(10, 5, 5), 0, 5.0, 20.0, true);
  const Physics physics = test::physicsOf({sphere}, container);
  Relaxation relaxation(physics, {}, {bodyAt(Vec3(-15, 90, 5), 0), bodyAt(Vec3(5, 5, -70), 1)});
  const auto cells = [&] { return relaxation.cells(); };
  CHECK((cells()[0].position - Vec3(5, 11, 5)).norm() < 1e-3);
  CHECK((cells()[1].position - Vec3(5, 5, -1)).norm() < 1e-3);
  ScheduleLimits limits;
  limits.maxSweeps = 300;
  CHECK(relax(relaxation, limits));
  for (const Body& cell : cells()) CHECK(container->wall()->distance(cell.position).distance > 0.99);
}

TEST_CASE("More clearance can be required of a pair and of a cell at the wall", "[relaxation]") {
  const auto sphere = test::sphereShape(1.0);
  const Physics physics = test::physicsOf({sphere}, makeBox(cube(12.0), {false, false, false}));
  Relaxation relaxation(
      physics, {},
      {bodyAt(Vec3(1.0, 6.0, 6.0), 4), bodyAt(Vec3(6.0, 6.0, 6.0), 2), bodyAt(Vec3(7.5, 6.0, 6.0), 3)});
  const auto settled = [&] {
    for (int k = 0; k < 80; ++k) relaxation.sweep(0.4);
    const std::vector<Body> c = relaxation.cells();
    REQUIRE(c.size() == 3);
    REQUIRE((c[0].id == 2 && c[2].id == 4));
    return std::make_pair((c[1].position - c[0].position).norm() - 2.0, c[2].position.x() - 1.0);
  };
  auto [gap, wallGap] = settled();
  REQUIRE(gap == Approx(0.02).margin(0.012));
  REQUIRE(wallGap == Approx(0.02).margin(0.012));
  relaxation.demandClearance(3, 2, 0.3);
  relaxation.demandWallClearance(4, 0.4);
  std::tie(gap, wallGap) = settled();
  REQUIRE(gap == Approx(0.32).margin(0.012));
  REQUIRE(wallGap == Approx(0.42).margin(0.012));
  relaxation.remove({3});
  REQUIRE(relaxation.cells().size() == 2);
  relaxation.sweep(1.0);
  REQUIRE(relaxation.lastSweep().deepest < 1e-3);
}

TEST_CASE("A few small cells in a large lumen cost little", "[relaxation]") {
  const auto sphere = test::sphereShape(0.5);
  const Box bounds = cube(20000.0);
  const Physics physics = physicsIn(bounds, {sphere});
  Relaxation relaxation(physics, {}, randomBodies(physics, 5, 1));
  REQUIRE(relaxation.sweep(1.0).contacts == 0);
  Relaxation empty(physicsIn(bounds, {}), {}, {});
  REQUIRE(empty.sweep(1.0).contacts == 0);
}

TEST_CASE("Schedules stop when requested", "[relaxation]") {
  const auto shape = test::redCellShape();
  const Box bounds = cube(20.0);
  // 0.75: infeasible
  const int count = int(0.75 * bounds.volume() / shape->volume());
  const Physics physics = physicsIn(bounds, {shape});
  Relaxation relaxation(physics, {}, randomBodies(physics, count, 1));
  ScheduleLimits limits;
  limits.maxSweeps = 25;
  int told = 0;
  limits.tell = [&](const char*) { ++told; };
  REQUIRE_FALSE(relax(relaxation, limits));
  REQUIRE(relaxation.sweeps() == 25);
  REQUIRE(told == 25);
  limits.maxSweeps = 1000;
  limits.stop = [&] { return relaxation.sweeps() >= 31; };
  REQUIRE_FALSE(relax(relaxation, limits));
  REQUIRE(relaxation.sweeps() == 31);
  limits.stop = nullptr;
  REQUIRE_FALSE(relaxDeepContacts(relaxation, 7, limits));
  REQUIRE(relaxation.sweeps() == 38);
}

TEST_CASE("The relaxation schedule unlocks interlocked dense cells", "[relaxation][long]") {
  const auto shape = test::redCellShape();
  const Box bounds = cube(30.0);
  const int count = int(0.62 * bounds.volume() / shape->volume());
  const auto lockedAfter = [&](Relaxation& relaxation, const std::function<void()>& sweep) {
    double depth = 0.0;  // while agitated it goes up and down
    for (int k = 0; k < 100; ++k) {
      sweep();
      depth += relaxation.lastSweep().meanDepth() / 100.0;
    }
    return depth > 0.35 * relaxation.halfThickness();
  };
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Physics physics = physicsIn(bounds, {shape});
    Relaxation relaxation(physics, {}, randomBodies(physics, count, seed));
    for (int k = 0; k < 200; ++k) relaxation.sweep(1.0);
    REQUIRE(lockedAfter(relaxation, [&] { relaxation.sweep(1.0); }));  // what the schedule is to avoid

    const auto scheduled = [&](Relaxation& which, SchedulePosition at) {
      return [&which, at]() mutable {
        ScheduleLimits limits;
        limits.maxSweeps = which.sweeps() + 1;
        relax(which, limits, at);
      };
    };
    const std::function<void()> annealed = scheduled(relaxation, {1, 1});
    for (int k = 0; k < 200; ++k) annealed();
    REQUIRE_FALSE(lockedAfter(relaxation, annealed));

    Relaxation other(physics, {}, randomBodies(physics, count, seed));
    const std::function<void()> fromTheStart = scheduled(other, {});
    for (int k = 0; k < 200; ++k) fromTheStart();
    REQUIRE_FALSE(lockedAfter(other, fromTheStart));
  }
}

TEST_CASE("Ellipsoids are resolved equally fast for any shortest axis", "[relaxation]") {
  const Box bounds = cube(32.0);
  for (const Vec3& axes : {Vec3(8.0, 3.0, 8.0), Vec3(8.0, 8.0, 3.0), Vec3(3.0, 8.0, 8.0),
                           Vec3(3.0, 10.0, 3.0), Vec3(9.8, 6.6, 3.5)}) {
    CAPTURE(axes);
    const auto shape = hemocell::makeEllipsoid(axes.x(), axes.y(), axes.z());
    const int count = int(0.58 * bounds.volume() / shape->volume());
    const Physics physics = physicsIn(bounds, {shape});
    Relaxation relaxation(physics, {}, randomBodies(physics, count, 1));
    ScheduleLimits limits;
    limits.maxSweeps = 60;
    REQUIRE(relax(relaxation, limits));
  }
}
