// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/analysis/profiles.h"
#include "packMesh/analysis/cell_measures.h"
#include "packMesh/container/vessel.h"
#include "packMesh/packing/packing_problem.h"
#include "tests/support/catch.h"
#include "tests/support/packings.h"

using namespace packmesh;

TEST_CASE("Depths in a vessel are exact near its wall and accurate inside") {
  const auto tube = makeCylinder(Vec3::Zero(), 0, 10.0, 50.0, false);
  const auto vessel = makeVessel(tube->surface(), {}, 0.5);
  const WallDepth depth(*vessel->wall(), vessel->bounds());
  REQUIRE(depth.spacing() < 1.0);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  int exact = 0, interpolated = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 at(part(random), part(random), part(random));
    const Vec3 p = vessel->bounds().lo + at.cwiseProduct(vessel->bounds().size());
    const double truth = vessel->wall()->distance(p).distance, found = depth(p);
    INFO(toText(p) << ": " << truth << ", " << found);
    REQUIRE(std::abs(found - truth) < 0.35 * depth.spacing());
    if (std::abs(truth) < 2.6 * depth.spacing()) REQUIRE(found == truth);
    ++(found == truth ? exact : interpolated);
  }
  REQUIRE(exact > 500);
  REQUIRE(interpolated > 500);
  const WallDepth closed(*tube->wall(), tube->bounds());
  REQUIRE(closed(Vec3(1, 2, 3)) == tube->wall()->distance(Vec3(1, 2, 3)).distance);
}

namespace {

constexpr double pi = 3.141592653589793;

PlacedCell cellAt(int species, const Vec3& position, const Mat3& turn = Mat3::Identity()) {
  return {species, species, {turn, position}};
}

PackingMeasures profilesOf(const PackingProblem& problem, const std::vector<PlacedCell>& cells,
                           const std::array<bool, 3>& ends = {false, false, false}) {
  return measurePacking(problem.physics, problem.execution, cells,
                        measureShare(problem.physics, problem.execution, cells).gap, ends);
}

double volumeIn(const Profile& profile, int species) {
  double volume = 0.0;
  for (int i = 0; i < profile.layers(); ++i) volume += profile.fraction[species][i] * profile.lumen[i];
  return volume;
}

PackingProblem balls(std::shared_ptr<const Container> container, double radius) {
  PackingProblem problem;
  problem.physics.container = std::move(container);
  problem.physics.add("ball", test::sphereShape(radius), 1);
  problem.physics.add("none", test::sphereShape(1.0), 0);
  return problem;
}

}  // namespace

TEST_CASE("Axial profiles contain the volume of the cells exactly, and each layer up to its error") {
  const PackingProblem problem = balls(test::periodicCube(20.0), 4.0);
  const Vec3 centre(19.0, 10.0, 5.0);  // across a face
  const PackingMeasures found = profilesOf(problem, {cellAt(0, centre)});
  const double volume = problem.physics.shapes[0]->volume();
  for (int k = 0; k < 3; ++k) {
    const Profile& profile = found.axial[k];
    REQUIRE(profile.layers() == 80);
    REQUIRE(volumeIn(profile, 0) == Approx(volume).epsilon(1e-5));
    REQUIRE(volumeIn(profile, 1) == 0.0);
    for (int i = 0; i < profile.layers(); ++i) {
      const double x = std::remainder(profile.middle(i) - centre[k], 20.0);
      const double exact = std::max(0.0, pi * (16.0 - x * x)) / 400.0;
      INFO(k << " " << profile.middle(i));
      REQUIRE(std::abs(profile.fraction[0][i] - exact) < 2.0 * profile.error[0][i] + 0.006);
      REQUIRE(profile.red[i] == profile.fraction[0][i]);
    }
  }
  REQUIRE(!found.wall);
  REQUIRE(found.lumenPoints == 0);
}

TEST_CASE("A tube has the right wall profile and cell-free layer") {
  const PackingProblem problem = balls(makeCylinder(Vec3(0, 0, 20), 2, 10.0, 40.0, true), 4.0);
  const PackingMeasures found =
      profilesOf(problem, {cellAt(0, {0, 0, 5}), cellAt(0, {0, 0, 15}), cellAt(0, {0, 0, 25})});
  REQUIRE(found.wall);
  const Profile& profile = *found.wall;
  REQUIRE(volumeIn(profile, 0) == Approx(3.0 * problem.physics.shapes[0]->volume()).epsilon(1e-5));
  for (int i = 0; i < profile.layers(); ++i) {
    const double outer = 10.0 - i * profile.width, inner = std::max(0.0, outer - profile.width);
    const double layer = pi * (outer * outer - inner * inner) * 40.0;
    // Standard deviation that independent points would have.
    const double each = 20.0 * 20.0 * 40.0 / double(found.lumenPoints);
    REQUIRE(std::abs(profile.lumen[i] - layer) < 4.0 * std::sqrt(layer * each));
    if (profile.begin + (i + 1) * profile.width < 5.9) REQUIRE(profile.fraction[0][i] == 0.0);
  }
  REQUIRE(profile.fraction[0][30] > 0.1);
  // Of the volume within r of the axis, chords of three balls fill 6 √(16 - r²) / 40: 5 % of the mean at 6
  // µm.
  REQUIRE(*layerBelow(profile, 0.05) == Approx(6.0).margin(0.15));
  REQUIRE(*layerBelow(profile, 0.05) < *layerBelow(profile, 0.5));
  REQUIRE(!layerBelow(profile, 100.0));
  REQUIRE(!layerBelow(profilesOf(problem, {}).axial[0], 0.05));
}

TEST_CASE("Ends without walls do not count as walls") {
  const PackingProblem problem = balls(makeCylinder(Vec3(0, 0, 20), 2, 10.0, 40.0, false), 4.0);
  const std::vector<PlacedCell> cells = {cellAt(0, {0, 0, 4.1}), cellAt(0, {0, 0, 20})};
  const PackingMeasures walls = profilesOf(problem, cells);
  const PackingMeasures ends = profilesOf(problem, cells, {false, false, true});
  REQUIRE(walls.wall->fraction[0][2] > 0.0);  // the cell at the end
  for (int i = 0; i < 22; ++i) REQUIRE(ends.wall->fraction[0][i] == 0.0);
  // A box without any walls has no profile.
  const PackingProblem box = balls(makeBox({Vec3::Zero(), Vec3(20, 20, 20)}, {false, false, false}), 4.0);
  REQUIRE(profilesOf(box, {cellAt(0, {10, 10, 10})}).wall);
  REQUIRE(!profilesOf(box, {cellAt(0, {10, 10, 10})}, {true, true, true}).wall);
}

TEST_CASE("Gaps are counted in bins, and cells without neighbours separately") {
  const PackingProblem problem = balls(test::periodicCube(40.0), 1.0);
  const PackingMeasures found =
      profilesOf(problem, {cellAt(0, {5, 5, 5}), cellAt(0, {7.51, 5, 5}), cellAt(0, {20, 5, 5}),
                           cellAt(0, {22.11, 5, 5}), cellAt(0, {24.21, 5, 5}), cellAt(0, {30, 30, 30})});
  const GapHistogram& gaps = found.gaps[0];
  REQUIRE(gaps.beyond == 1);
  REQUIRE(gaps.minimum == Approx(0.1).margin(0.03));
  REQUIRE(gaps.mean == Approx((2 * 0.51 + 2 * 0.1 + 0.11) / 5).margin(0.03));
  REQUIRE(gaps.median == Approx(0.11).margin(0.04));
  std::int64_t counted = 0;
  for (const std::int64_t n : gaps.counts) counted += n;
  REQUIRE(counted == 5);
  REQUIRE(found.gaps[1].beyond == 0);
  REQUIRE(found.gaps[1].minimum == 0.0);
}

TEST_CASE("Profiles and local hematocrits leave cells outside the lumen out") {
  PackingProblem problem = balls(makeCylinder({20, 10, 10}, 0, 10.0, 40.0, false), 3.0);
  problem.physics.species[0].inHematocrit = true;
  const std::vector<PlacedCell> inside = {cellAt(0, {10, 10, 10}), cellAt(0, {30, 10, 10})};
  std::vector<PlacedCell> all = {cellAt(0, {20, 30, 10}), inside[0], cellAt(0, {20, 19, 10}), inside[1]};
  std::set<std::int64_t> outside;
  const auto measuredWith = [&](const std::vector<PlacedCell>& cells) {
    const CellMeasures found = measureShare(problem.physics, problem.execution, cells, outside);
    return std::make_pair(measurePacking(problem.physics, problem.execution, cells, found.gap, {}, outside),
                          found.localHematocrit);
  };
  const auto [expected, expectedLocal] = measuredWith(inside);
  const auto [spoilt, spoiltLocal] = measuredWith(all);
  CHECK(spoilt.wall->red[0] > 0.02);  // as if they were at the wall
  outside = {0, 2};
  const auto [found, local] = measuredWith(all);
  CHECK(found.leftOut == 2);
  CHECK(expected.leftOut == 0);
  CHECK(found.wall->red[0] == 0.0);
  CHECK(volumeIn(*found.wall, 0) == Approx(2 * problem.physics.shapes[0]->volume()).epsilon(1e-5));
  for (int k = 0; k < 3; ++k)
    CHECK(volumeIn(found.axial[k], 0) == Approx(volumeIn(expected.axial[k], 0)).epsilon(1e-5));
  REQUIRE(layerBelow(*found.wall, 0.05));
  CHECK(*layerBelow(*found.wall, 0.05) == Approx(*layerBelow(*expected.wall, 0.05)).margin(0.02));
  CHECK(local[1] == expectedLocal[0]);
  CHECK(local[3] == expectedLocal[1]);
  CHECK(local[2] < 1.0);
  CHECK(spoiltLocal[1] >= local[1]);
  CHECK(found.gaps[0].beyond == 4);  // all cells count in gaps and orientation
  CHECK(found.orientation[0].cells == 4);
}

TEST_CASE("The order of symmetry axes is right for parallel, planar and random axes") {
  PackingProblem problem;
  problem.physics.container = test::periodicCube(100.0);
  problem.physics.add("RBC", test::redCellShape(), 1);
  const auto order = [&](const std::function<Mat3(int)>& turn) {
    std::vector<PlacedCell> cells;
    for (int i = 0; i < 200; ++i) cells.push_back(cellAt(0, {50, 50, 50}, turn(i)));
    return measurePacking(problem.physics, {}, cells, std::vector<double>(cells.size(), 0.1), {})
        .orientation[0];
  };
  const auto about = [](const Vec3& axis, double angle) {
    return Mat3(Quaternion::around(axis, angle).toRotationMatrix());
  };
  const OrientationOrder parallel = order([&](int i) { return about(Vec3::UnitX(), i % 2 ? pi : 0.0); });
  REQUIRE(parallel.cells == 200);
  REQUIRE(parallel.nematic() == Approx(1.0));
  REQUIRE(parallel.director.isApprox(Vec3::UnitY(), 1e-6));
  const OrientationOrder planar = order([&](int i) { return about(Vec3::UnitX(), i * pi / 200); });
  REQUIRE(planar.eigenvalues[2] == Approx(-0.5));
  REQUIRE(planar.eigenvalues[0] == Approx(0.25));
  const OrientationOrder none = order([&](int i) {
    return Mat3(about(Vec3::UnitY(), 2.399963 * i) *
                about(Vec3::UnitX(), std::acos(1.0 - (i + 0.5) / 100.0)));
  });
  REQUIRE(none.nematic() < 0.05);
  REQUIRE(none.tensor.trace() == Approx(0.0).margin(1e-8));
}
