// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/repairs.h"

#include "packMesh/core/tolerances.h"
#include "tests/support/catch.h"
#include "tests/support/packings.h"

using namespace packmesh;

TEST_CASE("calibration moves the gaps of pairs towards the smallest safe one", "[calibration]") {
  const double required = GENERATE(0.0, 0.1);
  // Model of a pair whose meshes can be nearer to each other than its sample points, by `nearer`.
  const double nearer = GENERATE(-0.015, 0.0, 0.004, 0.012);
  double extra = 0.0, gap = 0.0;
  for (int round = 0; round < 12; ++round) {
    gap = required + tolerance::relaxationMargin - tolerance::compactionSlack + extra + nearer;
    extra += clearanceCorrection(gap > 0.0 ? gap : 0.0, required, extra);
  }
  CHECK(gap > required + 0.0009);
  CHECK(gap < required + 0.003);
}

TEST_CASE("calibration gives more room to pairs that overlap, and leaves others enough of it",
          "[calibration]") {
  CHECK(clearanceCorrection(0.0, 0.0, 0.0) == tolerance::repairClearance);
  CHECK(clearanceCorrection(0.05, 0.1, 0.0) > 0.04);
  CHECK(clearanceCorrection(0.00125, 0.0, 0.0) == 0.0);
  CHECK(clearanceCorrection(0.03, 0.0, 0.0) < 0.0);
  CHECK(clearanceCorrection(0.03, 0.0, -0.03) == 0.0);
  const double steps = std::ldexp(clearanceCorrection(0.0217, 0.0, 0.0), 14);
  CHECK(steps == std::floor(steps));
}

TEST_CASE("cells that overlap after a compaction are calibrated until they do not", "[calibration]") {
  PackingProblem problem = test::toBeCalibrated(22.0, 0.5, 0.99);
  std::set<std::string> stages;
  problem.execution.progress = [&](const Progress& progress) { stages.insert(progress.stage); };
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::certified);
  CHECK(result.certificate.clean());
  CHECK(result.statistics.repairs > 0);
  CHECK(stages == std::set<std::string>{"calibration"});
}
