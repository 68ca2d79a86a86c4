// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/growth_relaxation.h"

#include <catch2/catch.hpp>

#include "packMesh/container/primitives.h"
#include "tests/support/growing.h"
#include "tests/support/physics.h"
#include "tests/support/shapes.h"

using namespace packmesh;

namespace {

struct Blood {
  std::shared_ptr<const Shape> red = test::redCellShape(), white = test::hemocellShape("WBC"),
                               platelet = test::hemocellShape("PLT");
  Physics physics;

  explicit Blood(std::shared_ptr<const Container> in)
      : physics(test::physicsOf({platelet, red, white}, std::move(in))) {}
};

std::shared_ptr<const Container> cubicBox(double edge, bool periodic) {
  return makeBox(Box{Vec3::Zero(), Vec3::Constant(edge)}, {periodic, periodic, periodic});
}

}  // namespace

TEST_CASE("Seeds are free of overlap and inside the lumen, whatever the lumen, scale and species") {
  const std::vector<std::shared_ptr<const Container>> containers = {
      cubicBox(30.0, true), makeBox(Box{Vec3::Zero(), Vec3::Constant(30.0)}, {false, true, false}),
      makeSphere(Vec3::Zero(), 16.0), makeCylinder(Vec3(20.0, 0.0, 0.0), 0, 12.0, 40.0, true)};
  for (const auto& container : containers)
    for (const double scale : {0.1, 0.4}) {
      CAPTURE(container->describe(), scale);
      Blood blood(container);
      blood.physics.clearance = 0.1;
      const std::vector<Body> cells = test::seeded(blood.physics, {20, 30, 2}, scale);
      REQUIRE(cells.size() == 52);
      for (std::size_t i = 0; i < cells.size(); ++i) {
        CHECK(cells[i].id == static_cast<std::int64_t>(i));
        CHECK(cells[i].species == (i < 20 ? 0 : i < 50 ? 1 : 2));
        CHECK(cells[i].scale == scale);
      }
      CHECK(test::examine(blood.physics, cells).clean());
    }
}

TEST_CASE("Seeds depend on the random seed alone, and orientations can be kept") {
  Blood blood(cubicBox(30.0, true));
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
  Blood blood(cubicBox(12.0, true));
  CHECK_THROWS(test::seeded(blood.physics, {0, 0, 40}, 0.9));
}

TEST_CASE("Existing cells keep their size where it is free, and are halved where they overlap") {
  Blood blood(cubicBox(30.0, false));
  std::vector<Body> cells;
  const auto add = [&](double scale, const Vec3& at) {
    cells.push_back(
        makeBody(static_cast<std::int64_t>(cells.size()), 1, 1, {scale, Quaternion::Identity(), at}));
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
  Blood blood(cubicBox(30.0, true));
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
