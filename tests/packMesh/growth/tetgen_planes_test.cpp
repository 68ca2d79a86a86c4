// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/tetgen_planes.h"

#include <catch2/catch.hpp>
#include <limits>

#include "packMesh/certificate/certify.h"
#include "packMesh/growth/cat_cells.h"
#include "packMesh/growth/growth.h"
#include "packMesh/growth/seeding.h"
#include "tests/support/packings.h"

using namespace packmesh;

namespace {

/// A packing as growth sees it, its cells shrunk about their centres.
struct Shrunk {
  PackingProblem problem;
  GrowthScene scene;
  GrowthState state;

  Shrunk(const std::shared_ptr<const Container>& container, double fraction, double scale)
      : problem(test::redCellProblem(container, fraction)) {
    scene.shapes = {problem.species[0].shape.get()};
    scene.walls = {container->wall()};
    scene.container = container.get();
    for (Pose pose : pack(problem).poses) {
      pose.scale = scale;
      state.push_back({0, pose});
    }
  }
  PlaneRequest request(double reach, double detail = 1.0) const {
    PlaneRequest out;
    out.reach.assign(state.size(), reach);
    out.detail = detail;
    return out;
  }
  std::vector<PlacedCell> cells() const {
    std::vector<PlacedCell> out;
    for (const GrowingCell& cell : state) out.push_back({cell.species, cell.pose.placement()});
    return out;
  }
};

/// The scale to which each cell can grow in place within its planes.
std::vector<double> scalesWithin(const PlaneConstraints& planes, const GrowthState& state) {
  std::vector<double> scales;
  for (std::size_t i = 0; i < state.size(); ++i) {
    const Pose& pose = state[i].pose;
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
    for (const TetgenUse use : {TetgenUse::facing, TetgenUse::faces}) {
      TetrahedraSums sums;
      const PlaneConstraints planes =
          TetgenPlanes(packing.scene, use, sums)(packing.state, packing.request(1.0));
      CHECK(sums.runs == 1);
      Shrunk grown = packing;
      const std::vector<double> scales = scalesWithin(planes, packing.state);
      for (std::size_t i = 0; i < planes.size(); ++i) {
        CHECK(planes[i].size() > 10);
        CHECK(scales[i] >= 0.8 - 1e-6);
        grown.state[i].pose.scale = std::min(1.0, scales[i] - 0.01);
      }
      const std::vector<PlacedCell> cells = grown.cells();
      CHECK(certify({packing.scene.shapes, packing.scene.walls, lumen.get(), &cells, 0.0}, 1e-3).clean());
    }
  }
}

TEST_CASE("Planes of cells that tetrahedra join are among those of all cells that are near") {
  for (const auto& lumen : lumens()) {
    const Shrunk packing(lumen, 0.35, 0.8);
    TetrahedraSums sums;
    const PlaneConstraints few =
        TetgenPlanes(packing.scene, TetgenUse::facing, sums)(packing.state, packing.request(1.0));
    const PlaneConstraints all = ChordPlanes(packing.scene)(packing.state, packing.request(1.0));
    std::size_t fewer = 0, more = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      CHECK(few[i].size() <= all[i].size());
      fewer += few[i].size();
      more += all[i].size();
    }
    CHECK(static_cast<double>(fewer) > 0.9 * static_cast<double>(more));
    // What they leave to a cell is the same: who is not joined does not bound.
    const std::vector<double> within = scalesWithin(few, packing.state),
                              than = scalesWithin(all, packing.state);
    for (std::size_t i = 0; i < within.size(); ++i) CHECK(within[i] == Approx(than[i]).epsilon(1e-6));
  }
}

TEST_CASE("Both kinds of planes leave a cell about the room of its CAT cell") {
  const auto lumen = lumens()[1];
  const Shrunk packing(lumen, 0.30, 0.8);
  TetrahedraSums sums;
  const std::vector<double> faces =
      scalesWithin(TetgenPlanes(packing.scene, TetgenUse::faces, sums)(packing.state, packing.request(3.0)),
                   packing.state);
  const std::vector<double> chords =
      scalesWithin(ChordPlanes(packing.scene)(packing.state, packing.request(3.0)), packing.state);
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

TEST_CASE("Tetrahedra serve until cells have moved far, or new ones are asked for") {
  Shrunk pair(test::periodicCube(20.0), 0.05, 0.8);
  pair.state = {{0, Pose{0.8, Quaternion::Identity(), Vec3(5.0, 5.0, 5.0)}},
                {0, Pose{0.8, Quaternion::Identity(), Vec3(13.0, 5.0, 5.0)}}};
  TetrahedraSums sums;
  TetgenPlanes builder(pair.scene, TetgenUse::facing, sums);
  GrowthState& state = pair.state;
  PlaneRequest request = pair.request(1.5);
  for (int k = 0; k < 4; ++k) builder(state, request);
  CHECK(sums.runs == 1);
  request.anew = true;
  const PlaneConstraints before = builder(state, request);
  CHECK(sums.runs == 2);
  CHECK(before[0].size() > 10);
  request.anew = false;
  // Wrapping around the period is no move.
  state[0].pose.position.x() += 20.0;
  const PlaneConstraints after = builder(state, request);
  CHECK(sums.runs == 2);
  REQUIRE(after[0].size() == before[0].size());
  for (std::size_t k = 0; k < after[0].size(); ++k)
    CHECK((after[0][k].point - before[0][k].point - Vec3(20.0, 0.0, 0.0)).norm() < 1e-9);
  state[0].pose.position.z() += 2.5;
  builder(state, request);
  CHECK(sums.runs == 3);
}

TEST_CASE("When TetGen gives up, planes are those of all cells that are near") {
  const Shrunk packing(test::periodicCube(13.0), 0.30, 0.8);
  TetrahedraSums sums;
  for (const TetgenUse use : {TetgenUse::facing, TetgenUse::faces}) {
    TetgenPlanes builder(packing.scene, use, sums, tetgenVariants);
    const PlaneConstraints planes = builder(packing.state, packing.request(0.5));
    const PlaneConstraints chords = ChordPlanes(packing.scene)(packing.state, packing.request(0.5));
    for (std::size_t i = 0; i < planes.size(); ++i) CHECK(planes[i].size() == chords[i].size());
  }
  CHECK(sums.failures == 2);
  CHECK(sums.attempts == 2 * tetgenVariants);
  CHECK_THAT(sums.lastFailure, Catch::Contains("TetGen gave up") && Catch::Contains("3 attempts"));
  TetgenPlanes second(packing.scene, TetgenUse::faces, sums, 1);
  second(packing.state, packing.request(0.5));
  CHECK(sums.failures == 2);
  CHECK(sums.attempts > 2 * tetgenVariants + 1);
}
