// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Growth after relaxation, and escape from local maxima.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "packMesh/packing/pack.h"
#include "tests/benchmark/growth/packings.h"
#include "tests/support/bodies.h"

namespace packmesh::benchmark {
namespace {

void regrowth(const Options& options) {
  fmt::print(
      "Red cells in a periodic box of 50 µm, default method; CPU [s], with the last cells that meet "
      "re-grown, and "
      "with relaxation alone; seeds 1 to {}.\n\n"
      "| fraction | seed | cells shrunk | smallest scale | clusters | unfinished | iterations | regrowth s | "
      "repairs "
      "| total s | repairs, relaxation alone | total s, relaxation alone |\n"
      "| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
      options.seeds);
  for (const double fraction : {0.50, 0.55, 0.58, 0.60})
    for (int seed = 1; seed <= options.seeds; ++seed) {
      PackingProblem problem = grownInBox(50.0, fraction);
      problem.method = Method::relaxation;
      problem.seed = static_cast<std::uint64_t>(seed);
      problem.regrowAfter = 0;
      PackingResult with, without;
      const double withSeconds = timeOf([&] { with = pack(problem); });
      problem.regrowAfter = -1;
      const double withoutSeconds = timeOf([&] { without = pack(problem); });
      const RegrowthSums& r = with.statistics.regrowth;
      fmt::print("| {:.2f} | {} | {} | {:.2f} | {} | {} | {} | {:.3f} | {} | {:.3f} | {} | {:.3f} |\n",
                 fraction, seed, r.cells, r.smallest, r.clusters, r.unfinished, r.growth.iterations,
                 r.seconds, with.statistics.repairs, withSeconds, without.statistics.repairs, withoutSeconds);
      std::fflush(stdout);
    }
}

void escapeFrom(const Options& options) {
  fmt::print(
      "Spheres, cubes, cones, tori and sickles, some more of each in stock; volume of all bodies, as large "
      "as they "
      "are, over that of the lumen.\n\n"
      "| lumen | seed | phase | coverage | bodies | full size | tried | changed | CPU s |\n"
      "| --- | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  const std::pair<std::string, std::shared_ptr<const Container>> lumens[] = {
      {"sphere", makeSphere(Vec3::Zero(), 9.0)}, {"vase", test::vase()}};
  for (const auto& [name, lumen] : lumens)
    for (int seed = 1; seed <= options.seeds; ++seed) {
      PackingProblem problem = test::mixtureIn(lumen, 8);
      for (Species& species : problem.species)
        species.count = std::llround(0.5 / 5.0 * lumen->volume() / species.shape->volume());
      problem.seed = static_cast<std::uint64_t>(seed);
      problem.escape.emplace();
      problem.escape->stock.assign(problem.species.size(), 3);
      const PackingResult result = pack(problem);
      for (const EscapePhase& p : result.statistics.escape)
        fmt::print("| {} | {} | {} | {:.4f} | {} | {} | {} | {} | {:.2f} |\n", name, seed, p.name, p.coverage,
                   p.cells, p.full, p.tried, p.changed, p.seconds);
      std::fflush(stdout);
    }
}

const AddCases cases({
    {"regrowth", "default method: cells that still meet re-grown in their cells, against relaxation alone",
     regrowth},
    {"escape", "coverage after swapping, enlargement, replacement and hole filling", escapeFrom},
});

}  // namespace
}  // namespace packmesh::benchmark
