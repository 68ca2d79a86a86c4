// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Does the bound on the rotation keep cells within their planes, or does the padding?
#include <fmt/format.h>

#include "packMesh/packing/pack.h"
#include "tests/benchmark/growth/packings.h"

namespace packmesh::benchmark {
namespace {

constexpr double edge = 25.0, fraction = 0.40;
constexpr int seeds = 3;

/// Violating pairs and stayed steps per 1000 steps, iterations, and how many runs came to an end, over the
/// seeds.
std::string measure(double rotation, double padding) {
  double pairs = 0.0, stayed = 0.0, steps = 0.0, iterations = 0.0;
  int certified = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    PackingProblem problem = grownInBox(edge, fraction);
    problem.physics.seed = static_cast<std::uint64_t>(seed);
    GrowthSettings& growth = test::useCat(problem).growth;
    growth.rotationBound = rotation;
    growth.padding = padding;
    growth.relaxationSweeps = 0;
    growth.maxIterations = 150;
    const PackingResult result = pack(problem);
    const GrowthStatistics& g = test::catStatistics(result).growth;
    certified += result.outcome == Outcome::certified;
    pairs += static_cast<double>(g.stepHalving.violatingPairs);
    stayed += static_cast<double>(g.stepHalving.stayed);
    steps += static_cast<double>(g.stepHalving.steps);
    iterations += static_cast<double>(g.iterations);
  }
  return fmt::format("{:.1f} / {:.1f} / {:.0f}{}", 1e3 * pairs / steps, 1e3 * stayed / steps,
                     iterations / seeds,
                     certified == seeds ? "" : fmt::format(" ({} of {})", certified, seeds));
}

void table() {
  const std::vector<double> paddings = {0.0, 0.02, 0.04, 0.08, 0.16};
  fmt::print("| θ_max [rad] \\ p |");
  for (const double padding : paddings) fmt::print(" {:.2f} |", padding);
  fmt::print("\n| --- |");
  for (std::size_t k = 0; k < paddings.size(); ++k) fmt::print(" ---: |");
  fmt::print("\n");
  for (const double rotation : {0.0125, 0.025, 0.05, 0.1, 0.2618}) {
    fmt::print("| {:.4f} |", rotation);
    for (const double padding : paddings) {
      fmt::print(" {} |", measure(rotation, padding));
      std::fflush(stdout);
    }
    fmt::print("\n");
  }
}

const AddCases cases(
    {{"padding",
      "violating pairs per 1000 steps / steps not taken per 1000 / iterations, by rotation bound "
      "and padding",
      [](const Options&) { table(); }}});

}  // namespace
}  // namespace packmesh::benchmark
