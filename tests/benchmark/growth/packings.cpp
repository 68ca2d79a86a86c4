// SPDX-License-Identifier: AGPL-3.0-or-later
#include "tests/benchmark/growth/packings.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "packMesh/certificate/certifier.h"
#include "packMesh/packing/pack.h"

namespace packmesh::benchmark {
namespace {

void print(const GrownPacking& packing, const Options& options) {
  double seconds = 0.0, back = 0.0;
  GrowthStatistics sums;
  int certified = 0;
  std::int64_t cells = 0, states = 0;
  double fraction = 0.0;
  bool valid = true;
  for (int seed = 1; seed <= options.seeds; ++seed) {
    PackingProblem problem = packing.problem();
    problem.physics.seed = static_cast<std::uint64_t>(seed);
    PackingResult result;
    seconds += timeOf([&] { result = pack(problem); });
    const GrowthStatistics& g = test::catStatistics(result).growth;
    certified += result.outcome == Outcome::certified;
    cells = static_cast<std::int64_t>(result.cells.size());
    fraction = result.certificate.cellVolume / problem.physics.container->volume();
    sums.iterations += g.iterations;
    sums.relaxationsKept += g.relaxationsKept;
    sums.planes += g.planes;
    sums.stepHalving.violatingPairs += g.stepHalving.violatingPairs;
    sums.stepHalving.misplaced += g.stepHalving.misplaced;
    back += g.stepHalvingSeconds;
    if (!options.check) continue;
    const std::int64_t seen = checkStates(problem);
    valid = valid && seen > 0;
    states += seen;
  }
  const double n = options.seeds;
  const auto mean = [n](std::int64_t sum) { return static_cast<double>(sum) / n; };
  fmt::print(
      "| {} | {} | {:.4f} | {:.0f} | {:.1f} | {:.0f} | {:.1f} | {:.1f} | {:.0f} | {:.3f} | {} | {} | {}/{} "
      "|\n",
      packing.name, cells, fraction, mean(sums.iterations), mean(sums.relaxationsKept), mean(sums.planes),
      mean(sums.stepHalving.violatingPairs), mean(sums.stepHalving.misplaced),
      seconds > 0.0 ? 100.0 * back / seconds : 0.0, seconds / n,
      packing.allowedSeconds > 0.0 ? fmt::format("{:g}", packing.allowedSeconds) : "",
      !options.check ? ""
      : valid        ? fmt::format("all {} valid", states)
                     : "NOT ALL VALID",
      certified, options.seeds);
  std::fflush(stdout);
}

}  // namespace

std::int64_t checkStates(PackingProblem problem) {
  std::int64_t states = 0;
  bool valid = true;
  problem.execution.observe = [&](const std::vector<PlacedCell>& cells) {
    valid = valid && certify(certificateInputOf(problem.physics, cells), 1e-3).clean();
    ++states;
  };
  pack(problem);
  return valid ? states : -1;
}

Case packings(std::string name, std::string about, std::vector<GrownPacking> of) {
  return {std::move(name), std::move(about), [of = std::move(of)](const Options& options) {
            std::puts(
                "| packing | cells | fraction | iterations | relaxations | planes | violating pairs | "
                "misplaced | "
                "step halving % | CPU s | allowed s | states | certified |\n"
                "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- | --- |");
            for (const GrownPacking& packing : of) print(packing, options);
          }};
}

std::unique_ptr<Container> sphereFor(const Shape& shape, std::int64_t count, double fraction) {
  return makeSphere(Vec3::Zero(),
                    std::cbrt(0.75 / M_PI * static_cast<double>(count) * shape.volume() / fraction));
}

PackingProblem grownInBox(double edge, double fraction, PlaneSource planeSource) {
  const auto shape = redCell();
  return grown(shape, static_cast<std::int64_t>(fraction * edge * edge * edge / shape->volume()),
               makeBox(Box{Vec3::Zero(), Vec3::Constant(edge)}, {true, true, true}), planeSource);
}

}  // namespace packmesh::benchmark
