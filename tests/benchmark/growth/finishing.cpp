// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Escape from local maxima.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "packMesh/packing/pack.h"
#include "tests/benchmark/growth/packings.h"
#include "tests/support/bodies.h"

namespace packmesh::benchmark {
namespace {

void escapeFrom(const Options& options) {
  fmt::print(
      "Spheres, cubes, cones, tori and sickles, half of the lumen if all were full size; three more of each "
      "and "
      "twenty small spheres in reserve. Coverage: volume of all bodies, as large as they are, over that of "
      "the "
      "lumen. Every state that growth or a phase accepts is certified by itself.\n\n"
      "| lumen | seed | phase | coverage | bodies | full size | tried | changed | CPU s | states |\n"
      "| --- | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: | --- |\n");
  const std::pair<std::string, std::shared_ptr<const Container>> lumens[] = {
      {"sphere", makeSphere(Vec3::Zero(), 9.0)}, {"vase", test::vase()}};
  for (const auto& [name, lumen] : lumens)
    for (int seed = 1; seed <= options.seeds; ++seed) {
      PackingProblem problem = test::mixtureIn(lumen, 8);
      for (Species& species : problem.physics.species)
        species.count = std::llround(0.5 / 5.0 * lumen->volume() / problem.physics.shapeOf(species).volume());
      problem.physics.seed = static_cast<std::uint64_t>(seed);
      EscapeSettings& escape = test::useCat(problem).escape.emplace();
      escape.reserve.assign(problem.physics.species.size(), 3);
      problem.physics.add("small sphere", std::make_shared<const Shape>(test::icosphere(2, 0.8)), 0);
      escape.reserve.push_back(20);
      const PackingResult result = pack(problem);
      const std::int64_t states = checkStates(problem);
      double before = 0.0;
      for (const EscapePhase& p : test::catStatistics(result).escape) {
        fmt::print("| {} | {} | {} | {:.4f}{} | {} | {} | {} | {} | {:.2f} | {} |\n", name, seed, p.name,
                   p.coverage, p.coverage < before - 1e-12 ? " LOWER" : "", p.cells, p.full, p.tried,
                   p.changed, p.seconds,
                   &p != &test::catStatistics(result).escape.back() ? ""
                   : states < 0                                     ? "NOT ALL VALID"
                                                                    : fmt::format("all {} valid", states));
        before = p.coverage;
      }
      std::fflush(stdout);
    }
}

const AddCases cases({
    {"escape", "coverage after swapping, enlargement, replacement and hole filling", escapeFrom},
});

}  // namespace
}  // namespace packmesh::benchmark
