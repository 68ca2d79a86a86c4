// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/cat_face_planes.h"

#include <catch2/catch.hpp>
#include <limits>

#include "packMesh/certificate/certify.h"
#include "packMesh/growth/cat_cells.h"
#include "packMesh/growth/growth.h"
#include "tests/support/growing.h"
#include "tests/support/packings.h"

using namespace packmesh;

namespace {

/// A packing as growth sees it, its cells shrunk about their centres.
struct Shrunk {
  PackingProblem problem;
  Execution execution;
  std::vector<Body> state;

  Shrunk(const std::shared_ptr<const Container>& container, double fraction, double scale)
      : problem(test::redCellProblem(container, fraction)) {
    for (Pose pose : pack(problem).poses) {
      pose.scale = scale;
      state.push_back(makeBody(static_cast<std::int64_t>(state.size()), 0, pose));
    }
  }
  PlaneConstraints planes(PlaneFunction&& planeFunction, double reach) const {
    return test::planesOf(planeFunction, problem.physics, state, reach);
  }
  std::vector<PlacedCell> cells() const {
    std::vector<PlacedCell> out;
    for (const Body& cell : state) out.push_back({cell.species, cell.pose().placement()});
    return out;
  }
};

/// The scale to which each cell can grow in place within its planes.
std::vector<double> scalesWithin(const PlaneConstraints& planes, const std::vector<Body>& state) {
  std::vector<double> scales;
  for (std::size_t i = 0; i < state.size(); ++i) {
    const Pose pose = state[i].pose();
    double most = 2.0;
    for (const PlaneConstraint& plane : planes[i]) {
      const double arm = plane.normal.dot(pose.orientation * plane.vertex);
      if (arm > 0.0) most = std::min(most, plane.normal.dot(plane.point - pose.position) / arm);
    }
    scales.push_back(most);
  }
  return scales;
}

std::vector<std::shared_ptr<const Container>> lumens() {
  return {test::periodicCube(13.0), makeSphere(Vec3::Zero(), 8.0)};
}

}  // namespace

TEST_CASE("Every vertex is behind its planes, and cells that grow up to them do not meet") {
  for (const auto& lumen : lumens()) {
    const Shrunk packing(lumen, 0.35, 0.8);
    TetrahedraSums sums;
    const PlaneConstraints planes =
        packing.planes(CatFacePlanes(packing.problem.physics, packing.execution, sums), 1.0);
    CHECK(sums.runs == 1);
    Shrunk grown = packing;
    const std::vector<double> scales = scalesWithin(planes, packing.state);
    for (std::size_t i = 0; i < planes.size(); ++i) {
      CHECK(planes[i].size() > 10);
      CHECK(scales[i] >= 0.8 - 1e-6);
      grown.state[i].scale = std::min(1.0, scales[i] - 0.01);
    }
    const std::vector<PlacedCell> cells = grown.cells();
    CHECK(certify(certificateInputOf(packing.problem.physics, cells), 1e-3).clean());
  }
}

TEST_CASE("Both kinds of planes leave a cell approximately the room of its CAT cell") {
  const auto lumen = lumens()[1];
  const Shrunk packing(lumen, 0.30, 0.8);
  TetrahedraSums sums;
  const std::vector<double> faces = scalesWithin(
      packing.planes(CatFacePlanes(packing.problem.physics, packing.execution, sums), 3.0), packing.state);
  const std::vector<double> chords =
      scalesWithin(packing.planes(ChordPlanes(packing.problem.physics), 3.0), packing.state);
  double sum = 0.0;
  for (std::size_t i = 0; i < chords.size(); ++i) {
    // Planes of chords halve the gap where it is narrowest. CAT faces halve edges between vertices, many of
    // which cross the gap at a slant, so that they leave less room, never more.
    CHECK(faces[i] < chords[i] + 0.01);
    CHECK(faces[i] > chords[i] - 0.16);
    sum += faces[i] - chords[i];
  }
  CHECK(std::abs(sum) / static_cast<double>(chords.size()) < 0.09);
}

TEST_CASE("If TetGen fails, the planes are those of all nearby cells") {
  const Shrunk packing(test::periodicCube(13.0), 0.30, 0.8);
  TetrahedraSums sums;
  const PlaneConstraints planes =
      packing.planes(CatFacePlanes(packing.problem.physics, packing.execution, sums, tetgenVariants), 0.5);
  const PlaneConstraints chords = packing.planes(ChordPlanes(packing.problem.physics), 0.5);
  for (std::size_t i = 0; i < planes.size(); ++i) CHECK(planes[i].size() == chords[i].size());
  CHECK(sums.failures == 1);
  CHECK(sums.attempts == tetgenVariants);
  CHECK_THAT(sums.lastFailure, Catch::Contains("TetGen gave up") && Catch::Contains("3 attempts"));
  packing.planes(CatFacePlanes(packing.problem.physics, packing.execution, sums, 1), 0.5);
  CHECK(sums.failures == 1);
  CHECK(sums.attempts > tetgenVariants + 1);
}
