// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Whole packings with planes from CAT faces, by one thread and by two.
#include <fmt/format.h>

#include <cstdio>

#include "packMesh/packing/pack.h"
#include "tests/benchmark/growth/packings.h"

namespace packmesh::benchmark {
namespace {

void packBox(double edge, double fraction, int threads, const Options& options) {
  double wall = 0.0, cpu = 0.0, tetrahedra = 0.0, faces = 0.0;
  std::int64_t cells = 0, iterations = 0, runs = 0, failures = 0, overlaps = 0;
  int certified = 0;
  for (int seed = 1; seed <= options.seeds; ++seed) {
    PackingProblem problem = grownInBox(edge, fraction, PlaneSource::catFaces);
    problem.physics.seed = static_cast<std::uint64_t>(seed);
    problem.execution.threads = Threads(threads);
    const Timer watch;
    const PackingResult result = pack(problem);
    wall += watch.wall();
    cpu += watch.cpu();
    certified += result.outcome == Outcome::certified;
    cells = static_cast<std::int64_t>(result.cells.size());
    iterations += result.statistics.engine->iterations();
    overlaps += test::catStatistics(result).growth.stepHalving.violatingPairs;
    runs += test::catStatistics(result).tetrahedra->runs;
    failures += test::catStatistics(result).tetrahedra->failures;
    tetrahedra += test::catStatistics(result).tetrahedra->tetrahedraSeconds;
    faces += test::catStatistics(result).tetrahedra->faceSeconds;
  }
  const double n = options.seeds;
  fmt::print(
      "| {:g}³, {:.2f} | {} | {} | {:.0f} | {:.0f} | {:.0f} | {:.0f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | "
      "{}/{} |\n",
      edge, fraction, cells, threads, static_cast<double>(iterations) / n, static_cast<double>(overlaps) / n,
      static_cast<double>(runs) / n, static_cast<double>(failures) / n, tetrahedra / n, faces / n, cpu / n,
      wall / n, certified, options.seeds);
  std::fflush(stdout);
}

void catFaces(const Options& options) {
  std::puts(
      "| periodic box | cells | threads | iterations | overlaps removed by step halving | "
      "tetrahedralisations | "
      "failed | tetrahedra CPU s | faces CPU s | all CPU s | wall s | certified |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- |");
  packBox(25.0, 0.30, 1, options);
  packBox(25.0, 0.40, 1, options);
  for (const int threads : {1, 2}) packBox(43.3, 0.30, threads, options);
  for (const int threads : {1, 2}) packBox(64.7, 0.30, threads, options);
}

const AddCases cases({{"threads-cat-faces", "periodic boxes with planes from CAT faces, one thread and two",
                       catFaces}});

}  // namespace
}  // namespace packmesh::benchmark
