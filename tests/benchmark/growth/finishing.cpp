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
      "Red cells in a periodic box of 50 µm, default method; CPU [s]. The cells that meet after relaxation, "
      "and "
      "after so many rounds of repair by it, are re-grown; and relaxation alone.\n\n"
      "| fraction | seed | regrowth after | cells shrunk | smallest scale | clusters | alone | unfinished | "
      "iterations | regrowth s | repairs | total s |\n"
      "| ---: | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  for (const double fraction : {0.50, 0.55, 0.58, 0.60})
    for (int seed = 1; seed <= options.seeds; ++seed)
      for (const int after : {0, 1, 8, -1}) {
        PackingProblem problem = grownInBox(50.0, fraction);
        problem.method = Method::relaxation;
        problem.seed = static_cast<std::uint64_t>(seed);
        problem.regrowAfter = after;
        PackingResult result;
        const double seconds = timeOf([&] { result = pack(problem); });
        const RegrowthSums& r = result.statistics.regrowth;
        fmt::print("| {:.2f} | {} | {} | {} | {:.3f} | {} | {} | {} | {} | {:.3f} | {} | {:.3f} |\n",
                   fraction, seed, after < 0 ? "never" : fmt::format("{} repairs", after), r.cells,
                   r.smallest, r.clusters, r.alone, r.unfinished, r.growth.iterations, r.seconds,
                   result.statistics.repairs, seconds);
        std::fflush(stdout);
      }
}

void escapeFrom(const Options& options) {
  fmt::print(
      "Spheres, cubes, cones, tori and sickles, half of the lumen if all were full size; three more of each "
      "and "
      "twenty small spheres in stock. Coverage: volume of all bodies, as large as they are, over that of the "
      "lumen. Every state that growth or a phase accepts is certified by itself.\n\n"
      "| lumen | seed | phase | coverage | bodies | full size | tried | changed | CPU s | states |\n"
      "| --- | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: | --- |\n");
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
      problem.species.push_back(
          {"small sphere", std::make_shared<const Shape>(test::icosphere(2, 0.8)), 0, nullptr});
      problem.escape->stock.push_back(20);
      const PackingResult result = pack(problem);
      const std::int64_t states = checkStates(problem);
      double before = 0.0;
      for (const EscapePhase& p : result.statistics.escape) {
        fmt::print("| {} | {} | {} | {:.4f}{} | {} | {} | {} | {} | {:.2f} | {} |\n", name, seed, p.name,
                   p.coverage, p.coverage < before - 1e-12 ? " LOWER" : "", p.cells, p.full, p.tried,
                   p.changed, p.seconds,
                   &p != &result.statistics.escape.back() ? ""
                   : states < 0                           ? "NOT ALL VALID"
                                                          : fmt::format("all {} valid", states));
        before = p.coverage;
      }
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
