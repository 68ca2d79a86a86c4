// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/cat_face_planes.h"

#include <sys/wait.h>

#include <cerrno>

#include "packMesh/cat/cat_cells.h"
#include "packMesh/cat/growth.h"
#include "packMesh/certificate/certifier.h"
#include "tests/support/catch.h"
#include "tests/support/growing.h"
#include "tests/support/packings.h"
#include "tests/support/tetgen_stand_in.h"

using namespace packmesh;

namespace {

/// A packing as growth sees it, its cells shrunk about their centres.
struct Shrunk {
  PackingProblem problem;
  Execution execution;
  std::vector<Body> state;

  Shrunk(const std::shared_ptr<const Container>& container, double fraction, double scale)
      : problem(test::redCellProblem(container, fraction)),
        state(test::bodiesAt(pack(problem).poses, scale)) {}
  PlaneConstraints planes(PlaneFunction&& planeFunction, double reach) const {
    return test::planesOf(planeFunction, problem.physics, state, reach);
  }
  std::vector<PlacedCell> cells() const {
    std::vector<PlacedCell> out;
    for (const Body& cell : state) out.push_back({cell.species, cell.shape, cell.pose().placement()});
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

/// Requests for the two halves of the cells, made by two threads, with a stand-in for packmesh-tetgen.
struct SideBySide {
  Shrunk packing{test::periodicCube(13.0), 0.40, 0.97};
  CellSurroundings surroundings{packing.problem.physics, packing.state,
                                std::vector<double>(packing.state.size(), 0.5),
                                std::vector<double>(packing.state.size(), 0.0)};
  std::vector<PlaneRequest> requests;
  TetrahedraSums sums;
  test::TemporaryFolder folder;
  std::string runs = (folder.path() / "runs").string();  ///< a line for each run

  SideBySide() {
    packing.execution.threads = Threads(2);
    const auto cells = std::int64_t(packing.state.size());
    for (std::size_t half = 0; half < 2; ++half) {
      requests.push_back({surroundings, {}, 1.0, 0.5, half});
      for (std::int64_t i = half == 0 ? 0 : cells / 2; i < (half == 0 ? cells / 2 : cells); ++i)
        requests.back().wanted.push_back(i);
    }
  }
  /// The planes of both halves. @param run what a run does after both have begun, a shell script
  std::vector<PlaneConstraints> planes(const std::string& run) {
    const test::TetgenStandIn standIn("echo run >> '" + runs + "'\n" + "while [ \"$(wc -l < '" + runs +
                                      "')\" -lt 2 ]; do sleep 0.01; done\n" + run);
    CatFacePlanes planeFunction(packing.problem.physics, packing.execution, sums);
    planeFunction.begin(requests);
    return {test::constraintsFor(planeFunction, requests[0]),
            test::constraintsFor(planeFunction, requests[1])};
  }
  std::size_t begun() const {
    std::ifstream file(runs);
    std::size_t lines = 0;
    for (std::string line; std::getline(file, line);) ++lines;
    return lines;
  }
};

std::size_t countOf(const PlaneConstraints& planes) {
  std::size_t count = 0;
  for (const std::vector<PlaneConstraint>& of : planes) count += of.size();
  return count;
}

bool hasChildren() {
  return waitpid(-1, nullptr, WNOHANG) != -1 || errno != ECHILD;
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
    // which cross the gap at a slant, so that they leave less room; hardly ever more, where the gap is wide
    // and vertices are few.
    CHECK(faces[i] < chords[i] + 0.02);
    CHECK(faces[i] > chords[i] - 0.16);
    sum += faces[i] - chords[i];
  }
  CHECK(std::abs(sum) / double(chords.size()) < 0.09);
}

TEST_CASE("If TetGen fails, the planes are those of all nearby cells") {
  const Shrunk packing(test::periodicCube(13.0), 0.40, 0.97);
  TetrahedraSums sums;
  const PlaneConstraints planes =
      packing.planes(CatFacePlanes(packing.problem.physics, packing.execution, sums, tetgenVariants), 0.5);
  const PlaneConstraints chords = packing.planes(ChordPlanes(packing.problem.physics), 0.5);
  for (std::size_t i = 0; i < planes.size(); ++i) CHECK(planes[i].size() == chords[i].size());
  CHECK(sums.failures == 1);
  CHECK(sums.attempts == tetgenVariants);
  CHECK_THAT(sums.lastFailure, Contains("TetGen gave up") && Contains("3 attempts"));
  packing.planes(CatFacePlanes(packing.problem.physics, packing.execution, sums, 1), 0.5);
  CHECK(sums.failures == 1);
  CHECK(sums.attempts > tetgenVariants + 1);
}

TEST_CASE("Requests are tetrahedralised side by side, with the result of one after the other") {
  SideBySide both, single;
  const auto together = both.planes("exec " + test::TetgenStandIn::real());  // each waits for the other
  CHECK(both.sums.failures == 0);
  CHECK(both.sums.runs == 2);
  single.packing.execution.threads = Threads();
  CatFacePlanes planeFunction(single.packing.problem.physics, single.packing.execution, single.sums);
  planeFunction.begin(single.requests);
  for (int half = 0; half < 2; ++half) {
    const PlaneConstraints alone = test::constraintsFor(planeFunction, single.requests[half]);
    REQUIRE(alone.size() == together[half].size());
    for (std::size_t i = 0; i < alone.size(); ++i) {
      REQUIRE(alone[i].size() == together[half][i].size());
      for (std::size_t k = 0; k < alone[i].size(); ++k) {
        CHECK(alone[i][k].point == together[half][i][k].point);
        CHECK(alone[i][k].normal == together[half][i][k].normal);
      }
    }
  }
  CHECK_FALSE(hasChildren());
}

TEST_CASE("A run that is killed beside another one is repeated") {
  SideBySide both;
  const auto planes =
      both.planes("mkdir '" + both.runs + ".first' && kill -9 $$\nexec " + test::TetgenStandIn::real());
  CHECK(both.sums.runs == 2);
  CHECK(both.sums.failures == 0);
  CHECK(both.begun() == 3);  // the one that was killed has been repeated
  CHECK(countOf(planes[0]) > 100);
  CHECK(countOf(planes[1]) > 100);
  CHECK_FALSE(hasChildren());
}

TEST_CASE("If all runs are killed, the planes are those of chords, and the signal is named") {
  SideBySide both;
  const auto planes = both.planes("kill -9 $$");
  CHECK(both.sums.failures == 2);
  CHECK_THAT(both.sums.lastFailure, Contains("was ended by signal 9 (Killed)"));
  ChordPlanes chords(both.packing.problem.physics);
  for (int half = 0; half < 2; ++half)
    CHECK(countOf(planes[half]) == countOf(test::constraintsFor(chords, both.requests[half])));
  CHECK_FALSE(hasChildren());
}

TEST_CASE("Runs that never answer are stopped, whichever thread waits for them") {
  for (const bool onlyOne : {false, true}) {
    SideBySide both;
    both.packing.execution.interrupted = [&] { return both.begun() >= 2; };
    both.planes(onlyOne ? "mkdir '" + both.runs + ".first' || exec " + test::TetgenStandIn::real() +
                              "\nexec sleep 100000"
                        : "exec sleep 100000");
    CHECK(both.sums.failures >= 1);
    CHECK_THAT(both.sums.lastFailure, Contains("it was stopped"));
    CHECK_FALSE(hasChildren());
  }
}
