// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/step_halving.h"
#include "tests/support/catch.h"
#include "tests/support/growing.h"
#include "tests/support/physics.h"
#include "tests/support/shapes.h"

using namespace packmesh;

namespace {

struct Spheres {
  std::shared_ptr<const Shape> shape = test::sphereShape(1.0);
  Physics physics;
  std::vector<Body> state;

  Spheres(std::shared_ptr<const Container> in, const std::vector<Vec3>& centers)
      : physics(test::physicsOf({shape}, std::move(in))) {
    for (const Vec3& center : centers)
      state.push_back(makeBody(std::int64_t(state.size()), 0, 0, Pose{1.0, Quaternion::Identity(), center}));
  }
};

GrowthStep moveBy(const Vec3& translation) {
  GrowthStep step;
  step.translation = translation;
  return step;
}

/// The part of its step that each cell took.
std::vector<double> taken(const std::vector<Body>& cells) {
  std::vector<double> parts;
  for (const Body& cell : cells) parts.push_back(cell.stepTaken);
  return parts;
}

bool sameBits(const Pose& a, const Pose& b) {
  return a.scale == b.scale && a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}

}  // namespace

TEST_CASE("Steps that keep cells apart are applied entirely") {
  Spheres s(test::cubicBox(10.0, true), {Vec3(2.0, 5.0, 5.0), Vec3(6.0, 5.0, 5.0)});
  StepHalvingSums sums;
  test::takeSteps(s.physics, {moveBy(Vec3(0.5, 0, 0)), moveBy(Vec3(-0.5, 0, 0))}, s.state, sums);
  CHECK(s.state[0].position.x() == 2.5);
  CHECK(s.state[1].position.x() == 5.5);
  CHECK(taken(s.state) == std::vector<double>{1.0, 1.0});
  CHECK(sums.steps == 2);
  CHECK(sums.violatingPairs == 0);
}

TEST_CASE("Only the steps of an offending pair are halved") {
  Spheres s(test::cubicBox(20.0, true), {Vec3(2.0, 5.0, 5.0), Vec3(6.0, 5.0, 5.0), Vec3(10.0, 15.0, 10.0)});
  StepHalvingSums sums;
  test::takeSteps(s.physics, {moveBy(Vec3(1.5, 0, 0)), moveBy(Vec3(-1.5, 0, 0)), moveBy(Vec3(1.5, 0, 0))},
                  s.state, sums);
  CHECK(taken(s.state) == std::vector<double>{0.5, 0.5, 1.0});
  CHECK(s.state[0].position.x() == 2.75);
  CHECK(s.state[2].position.x() == 11.5);
  CHECK(sums.violatingPairs == 1);
  CHECK(sums.stayed == 0);
}

TEST_CASE("A step that cannot be applied at all leaves the pose unchanged to the bit") {
  Spheres s(test::cubicBox(10.0, true), {Vec3(2.0, 5.0, 5.0), Vec3(4.01, 5.0, 5.0)});
  const std::vector<Body> before = s.state;
  GrowthStep turn = moveBy(Vec3(3.0, 0, 0));
  turn.rotation = Vec3(0.1, 0.2, 0.3);
  StepHalvingSums sums;
  test::takeSteps(s.physics, {turn, moveBy(Vec3::Zero())}, s.state, sums);
  CHECK(taken(s.state)[0] == 0.0);
  CHECK(sameBits(s.state[0].pose(), before[0].pose()));
  CHECK(sameBits(s.state[1].pose(), before[1].pose()));
  CHECK(sums.stayed == 1);
}

TEST_CASE("Steps out of the lumen, or closer to the wall than the clearance, are reverted") {
  Spheres s(test::cubicBox(10.0, false), {Vec3(2.0, 5.0, 5.0)});
  StepHalvingSums sums;
  test::takeSteps(s.physics, {moveBy(Vec3(-1.5, 0, 0))}, s.state, sums);
  CHECK(s.state[0].position.x() == 1.25);
  CHECK(sums.misplaced == 1);
  s.physics.wallClearance = 0.19;
  test::takeSteps(s.physics, {moveBy(Vec3(-0.2, 0, 0))}, s.state, sums);
  CHECK(s.state[0].position.x() == 1.25 - 0.2 / 4.0);
}

TEST_CASE("A required gap enlarges the cells, and images are neighbours") {
  Spheres s(test::cubicBox(10.0, true),
            {Vec3(1.5, 5.0, 5.0), Vec3(8.5, 5.0, 5.0)});  // 1 µm apart, across the boundary
  s.physics.clearance = 0.3;
  StepHalvingSums sums;
  test::takeSteps(s.physics, {moveBy(Vec3(-0.8, 0, 0)), moveBy(Vec3::Zero())}, s.state, sums);
  CHECK(sums.violatingPairs == 1);
  CHECK(s.state[0].position.x() == 1.1);
  test::takeSteps(s.physics, {moveBy(Vec3(0.0, 7.0, 0)), moveBy(Vec3::Zero())}, s.state, sums);
  CHECK(s.state[0].position.y() == Approx(2.0));  // wrapped into the period
}

TEST_CASE("States stay valid and no cell shrinks for any proposed step") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const Physics physics = test::physicsOf({test::redCellShape()}, test::cubicBox(14.0, true));
  std::vector<Body> state = test::seeded(physics, {8}, 0.2);
  StepHalvingSums sums;
  for (int round = 0; round < 40; ++round) {
    const std::vector<Body> before = state;
    std::vector<GrowthStep> steps;
    for (const Body& c : state) {
      GrowthStep step = moveBy(2.0 * unit(random) * test::randomDirection(random));
      step.scale = std::min(1.0, c.scale + 0.2 * unit(random));
      step.rotation = 0.5 * test::randomDirection(random);
      steps.push_back(step);
    }
    test::takeSteps(physics, steps, state, sums);
    CHECK(test::examine(physics, state).clean());
    for (std::size_t i = 0; i < state.size(); ++i) CHECK(state[i].scale >= before[i].scale);
  }
  CHECK(sums.violatingPairs > 20);
}

namespace {

struct Blood {
  std::shared_ptr<const Shape> red = test::redCellShape(), white = test::hemocellShape("WBC"),
                               platelet = test::hemocellShape("PLT");
  Physics physics;

  explicit Blood(std::shared_ptr<const Container> in)
      : physics(test::physicsOf({platelet, red, white}, std::move(in))) {}
};

}  // namespace

TEST_CASE("Seeds are free of overlap and inside the lumen, whatever the lumen, scale and species") {
  const std::vector<std::shared_ptr<const Container>> containers = {
      test::cubicBox(30.0, true), makeBox(Box{Vec3::Zero(), Vec3::Constant(30.0)}, {false, true, false}),
      makeSphere(Vec3::Zero(), 16.0), makeCylinder(Vec3(20.0, 0.0, 0.0), 0, 12.0, 40.0, true)};
  for (const auto& container : containers)
    for (const double scale : {0.1, 0.4}) {
      CAPTURE(container->describe(), scale);
      Blood blood(container);
      blood.physics.clearance = 0.1;
      const std::vector<Body> cells = test::seeded(blood.physics, {20, 30, 2}, scale);
      REQUIRE(cells.size() == 52);
      for (std::size_t i = 0; i < cells.size(); ++i) {
        CHECK(cells[i].id == std::int64_t(i));
        CHECK(cells[i].species == (i < 20 ? 0 : i < 50 ? 1 : 2));
        CHECK(cells[i].scale == scale);
      }
      CHECK(test::examine(blood.physics, cells).clean());
    }
}

TEST_CASE("Seeds depend on the random seed alone, and orientations can be kept") {
  Blood blood(test::cubicBox(30.0, true));
  const std::vector<Body> first = test::seeded(blood.physics, {0, 10, 0}, 0.1);
  const std::vector<Body> again = test::seeded(blood.physics, {0, 10, 0}, 0.1);
  blood.physics.seed = 2;
  blood.physics.rotate = false;
  const std::vector<Body> other = test::seeded(blood.physics, {0, 10, 0}, 0.1);
  for (int i = 0; i < 10; ++i) {
    CHECK(first[i].position == again[i].position);
    CHECK(first[i].orientation.coeffs() == again[i].orientation.coeffs());
    CHECK(first[i].position != other[i].position);
    CHECK(other[i].orientation.coeffs() == Quaternion::Identity().coeffs());
  }
}

TEST_CASE("Seeding fails where cells overlap even at their smallest scale") {
  Blood blood(test::cubicBox(12.0, true));
  CHECK_THROWS(test::seeded(blood.physics, {0, 0, 40}, 0.9));
}

TEST_CASE("Existing cells keep their size where it is free, and are halved where they overlap") {
  Blood blood(test::cubicBox(30.0, false));
  std::vector<Body> cells;
  const auto add = [&](double scale, const Vec3& at) {
    cells.push_back(makeBody(std::int64_t(cells.size()), 1, 1, {scale, Quaternion::Identity(), at}));
  };
  add(1.0, Vec3(8.0, 8.0, 8.0));     // alone
  add(1.0, Vec3(20.0, 20.0, 20.0));  // these two overlap
  add(1.0, Vec3(20.0, 21.0, 20.0));
  add(1.0, Vec3(1.0, 20.0, 8.0));  // in the wall
  add(0.1, Vec3(8.0, 8.0, 8.1));   // a seed inside the first one makes room itself
  REQUIRE(seed(blood.physics, {}, 0.1, {}, cells));
  CHECK(cells[0].scale == 1.0);
  CHECK(cells[1].scale < 1.0);
  CHECK(cells[2].scale < 1.0);
  CHECK(cells[3].scale < 1.0);
  CHECK(cells[4].scale == 0.1);
  CHECK(test::examine(blood.physics, cells).clean());
}

TEST_CASE("Seeding never moves or shrinks fixed cells") {
  Blood blood(test::cubicBox(30.0, true));
  blood.physics.species[2].freedom.fixed = true;
  std::vector<Body> cells = {makeBody(0, 2, 2, {1.0, Quaternion::Identity(), Vec3::Constant(15.0)}),
                             makeBody(1, 1, 1, {1.0, Quaternion::Identity(), Vec3(15.0, 15.0, 19.0)}),
                             makeBody(2, 0, 0, {0.1, Quaternion::Identity(), Vec3(15.0, 15.0, 15.5)})};
  REQUIRE(seed(blood.physics, {}, 0.1, {}, cells));
  CHECK(cells[0].scale == 1.0);
  CHECK(cells[0].position == Vec3::Constant(15.0));
  CHECK(cells[1].scale < 1.0);
  CHECK(test::examine(blood.physics, cells).clean());
}
