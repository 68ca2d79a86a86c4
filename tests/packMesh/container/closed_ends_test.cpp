// SPDX-License-Identifier: AGPL-3.0-or-later
// Where a lumen ends, nothing is near what is at its other end; where it repeats, its ends are neighbours.

#include "packMesh/certificate/certificate.h"
#include "packMesh/certificate/certifier.h"
#include "packMesh/relaxation/relaxation.h"
#include "tests/support/catch.h"
#include "tests/support/packings.h"
#include "tests/support/physics.h"
#include "tests/support/walls.h"

using namespace packmesh;

namespace {

constexpr double length = 20.0;

std::vector<std::shared_ptr<const Container>> lumens(bool periodic) {
  return {
      makeCylinder({0.5 * length, 0.0, 0.0}, 0, 6.0, length, periodic),
      makeBox(Box{{0.0, -6.0, -6.0}, {length, 6.0, 6.0}}, {periodic, false, false}),
      makeVessel(sample::straightTube(0.0, length, 6.0, 11, 40), VesselEnds{0, 0.0, length, periodic}, 0.25)};
}

/// Two spheres of radius 1, each 0.1 µm from an end.
std::vector<Vec3> besideTheEnds() {
  return {{1.1, 0.2, 0.1}, {length - 1.1, 0.2, 0.1}};
}

std::vector<Body> bodiesAt(const std::vector<Vec3>& positions) {
  std::vector<Body> bodies;
  for (const Vec3& p : positions) {
    Body body;
    body.position = p;
    body.id = std::int64_t(bodies.size());
    bodies.push_back(body);
  }
  return bodies;
}

}  // namespace

TEST_CASE("Cells are not pushed through a closed end, but through a periodic one", "[container]") {
  const auto sphere = test::sphereShape(1.0);
  for (const bool periodic : {false, true})
    for (const auto& container : lumens(periodic)) {
      CAPTURE(container->describe());
      Physics physics = test::physicsOf({sphere}, container);
      physics.clearance = 0.48;
      Relaxation relaxation(physics, {}, bodiesAt(besideTheEnds()));
      for (int k = 0; k < 40; ++k) relaxation.sweep(0.5);
      const std::vector<Body> cells = relaxation.cells();
      const double across = cells[0].position.x() + length - cells[1].position.x() - 2.0;
      if (periodic) {
        REQUIRE(across == Approx(0.5).margin(0.02));
      } else {
        REQUIRE(across == Approx(0.2).margin(1e-12));
        REQUIRE(relaxation.lastSweep().contacts == 0);
      }
    }
}

TEST_CASE("Separation is proved across a periodic end only", "[container][certificate]") {
  const auto sphere = test::sphereShape(1.0);
  for (const bool periodic : {false, true})
    for (const auto& container : lumens(periodic)) {
      CAPTURE(container->describe());
      std::vector<PlacedCell> cells;
      for (const Vec3& p : besideTheEnds()) cells.push_back({0, 0, Placement{Mat3::Identity(), p}});
      const CertificateInput input{{sphere.get()}, {container->wall()}, container.get(), &cells, 0.5};
      const Certificate certificate = certify(input);
      REQUIRE(certificate.misplaced.empty());
      REQUIRE(certificate.clean() != periodic);
      if (periodic) {
        REQUIRE(certificate.minimumGap == Approx(0.2).margin(0.02));
      } else {
        REQUIRE(certificate.pairsTested == 0);
        REQUIRE(std::isinf(certificate.minimumGap));
      }
    }
}

TEST_CASE("A lumen filled to its closed ends keeps clearances inside, but not across the ends",
          "[container][packing]") {
  // So short and so full that cells lie along both ends.
  const auto lumen = [](bool periodic) { return makeCylinder({6.0, 0.0, 0.0}, 0, 12.0, 12.0, periodic); };
  const std::shared_ptr<const Container> joined = lumen(true);
  double leastAcross = 1.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    PackingProblem problem = test::redCellProblem(lumen(false), 0.25, seed);
    problem.physics.clearance = 0.3;
    const PackingResult result = pack(problem);
    REQUIRE(result.outcome == Outcome::certified);
    REQUIRE(result.certificate.minimumGap >= problem.physics.clearance);
    const Certificate across =
        certify({{problem.physics.shapes[0].get()}, {joined->wall()}, joined.get(), &result.cells, 0.0});
    // As neighbours they may be nearer than that, though they do not meet: each is within the lumen.
    REQUIRE(across.clean());
    leastAcross = std::min(leastAcross, across.minimumGap);
  }
  REQUIRE(leastAcross < 0.25);
}
