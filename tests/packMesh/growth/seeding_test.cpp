// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/seeding.h"

#include <catch2/catch.hpp>

#include "packMesh/container/primitives.h"
#include "packMesh/core/error.h"
#include "packMesh/growth/power_diagram.h"
#include "packMesh/growth/step_halving.h"
#include "tests/support/shapes.h"

using namespace packmesh;

namespace {

struct Blood {
  std::shared_ptr<const Shape> red = test::redCellShape(), white = test::hemocellShape("WBC"),
                               platelet = test::hemocellShape("PLT");
  std::shared_ptr<const Container> container;
  GrowthScene scene;

  explicit Blood(std::shared_ptr<const Container> in) : container(std::move(in)) {
    scene.shapes = {platelet.get(), red.get(), white.get()};
    scene.walls = {container->wall(), container->wall(), container->wall()};
    scene.container = container.get();
  }
};

double imageDistance(const Vec3& a, const Vec3& b, const Vec3& period) {
  Vec3 d = a - b;
  for (int k = 0; k < 3; ++k)
    if (period[k] > 0.0) d[k] -= period[k] * std::round(d[k] / period[k]);
  return d.norm();
}

void checkSpheres(const GrowthScene& scene, const GrowthState& state) {
  for (std::size_t i = 0; i < state.size(); ++i) {
    const double radius = state[i].pose.scale * scene.shapes[state[i].species]->radius();
    if (const Wall* wall = scene.walls[state[i].species])
      CHECK(wall->distance(state[i].pose.position).distance > radius);
    CHECK(scene.container->bounds().contains(state[i].pose.position));
    for (std::size_t j = 0; j < i; ++j)
      CHECK(imageDistance(state[i].pose.position, state[j].pose.position, scene.container->period()) >
            radius + state[j].pose.scale * scene.shapes[state[j].species]->radius() + scene.clearance);
  }
}

}  // namespace

TEST_CASE("Bounding spheres of seeds do not meet and are inside the lumen") {
  const std::vector<std::shared_ptr<const Container>> containers = {
      makeBox(Box{Vec3::Zero(), Vec3::Constant(30.0)}, {true, true, true}),
      makeBox(Box{Vec3::Zero(), Vec3::Constant(30.0)}, {false, true, false}), makeSphere(Vec3::Zero(), 16.0),
      makeCylinder(Vec3(20.0, 0.0, 0.0), 0, 12.0, 40.0, true)};
  for (const auto& container : containers)
    for (const double scale : {0.1, 0.4}) {
      CAPTURE(container->describe(), scale);
      Blood blood(container);
      blood.scene.clearance = 0.1;
      const GrowthState state = seedRandomly(blood.scene, {20, 30, 2}, {"PLT", "RBC", "WBC"}, scale);
      REQUIRE(state.size() == 52);
      CHECK(state[19].species == 0);
      CHECK(state[20].species == 1);
      CHECK(state[51].species == 2);
      checkSpheres(blood.scene, state);
      CHECK(StepHalving(blood.scene).examine(state).clean());
    }
}

TEST_CASE("Seed poses depend only on the random seed, and orientations can be fixed") {
  Blood blood(makeBox(Box{Vec3::Zero(), Vec3::Constant(30.0)}, {true, true, true}));
  const GrowthState first = seedRandomly(blood.scene, {0, 10, 0}, {"PLT", "RBC", "WBC"}, 0.1);
  const GrowthState again = seedRandomly(blood.scene, {0, 10, 0}, {"PLT", "RBC", "WBC"}, 0.1);
  blood.scene.seed = 2;
  blood.scene.rotate = false;
  const GrowthState other = seedRandomly(blood.scene, {0, 10, 0}, {"PLT", "RBC", "WBC"}, 0.1);
  for (int i = 0; i < 10; ++i) {
    CHECK(first[i].pose.position == again[i].pose.position);
    CHECK(first[i].pose.orientation.coeffs() == again[i].pose.orientation.coeffs());
    CHECK(first[i].pose.position != other[i].pose.position);
    CHECK(other[i].pose.orientation.coeffs() == Quaternion::Identity().coeffs());
  }
}

TEST_CASE("A seed that does not fit is an error that names the cell") {
  Blood blood(makeBox(Box{Vec3::Zero(), Vec3::Constant(12.0)}, {true, true, true}));
  CHECK_THROWS_WITH(seedRandomly(blood.scene, {0, 0, 40}, {"PLT", "RBC", "WBC"}, 0.9),
                    Catch::Contains("species 'WBC'") && Catch::Contains("0.9"));
}

TEST_CASE("The power diagram gives large cells more room and keeps states valid") {
  for (const bool periodic : {true, false}) {
    CAPTURE(periodic);
    Blood blood(makeBox(Box{Vec3::Zero(), Vec3::Constant(30.0)}, {periodic, periodic, periodic}));
    GrowthState state = seedRandomly(blood.scene, {60, 60, 6}, {"PLT", "RBC", "WBC"}, 0.1);
    const GrowthState random = state;
    // Distance to the nearest neighbour, relative to the size of both: of all cells on average, and the
    // least.
    const auto spread = [&](const GrowthState& of) {
      double sum = 0.0, least = 1e30;
      for (std::size_t i = 0; i < of.size(); ++i) {
        double nearest = 1e30;
        for (std::size_t j = 0; j < of.size(); ++j)
          if (i != j)
            nearest = std::min(
                nearest, imageDistance(of[i].pose.position, of[j].pose.position, blood.container->period()) /
                             (std::cbrt(blood.scene.shapes[of[i].species]->volume()) +
                              std::cbrt(blood.scene.shapes[of[j].species]->volume())));
        sum += nearest;
        least = std::min(least, nearest);
      }
      return std::pair(sum / static_cast<double>(of.size()), least);
    };
    spreadByPowerDiagram(blood.scene, 10, state);
    CHECK(spread(state).first > 1.3 * spread(random).first);
    // Platelets that are hidden by the power cells of white ones are led out.
    CHECK(spread(state).second > 2.0 * spread(random).second);
    checkSpheres(blood.scene, state);
    for (std::size_t i = 0; i < state.size(); ++i) {
      CHECK(state[i].pose.scale == random[i].pose.scale);
      CHECK(state[i].pose.orientation.coeffs() == random[i].pose.orientation.coeffs());
    }
  }
}

TEST_CASE("Only cells that differ in volume are redistributed") {
  Blood blood(makeBox(Box{Vec3::Zero(), Vec3::Constant(30.0)}, {true, true, true}));
  const std::vector<std::string> names = {"PLT", "RBC", "WBC"};
  const GrowthSettings settings;
  const GrowthState same = seed(blood.scene, {0, 10, 0}, names, settings);
  const GrowthState random = seedRandomly(blood.scene, {0, 10, 0}, names, settings.initialScale);
  for (int i = 0; i < 10; ++i) CHECK(same[i].pose.position == random[i].pose.position);
  const GrowthState mixed = seed(blood.scene, {10, 10, 0}, names, settings);
  const GrowthState mixedRandom = seedRandomly(blood.scene, {10, 10, 0}, names, settings.initialScale);
  CHECK(mixed[0].pose.position != mixedRandom[0].pose.position);
}
