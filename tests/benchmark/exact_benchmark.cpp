// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Time of the exact pair test on red cells at the distances of dense packings.
#include <benchmark/benchmark.h>

#include <random>

#include "packMesh/geometry/mesh_intersection.h"
#include "tests/packMesh/geometry/test_meshes.h"

using namespace packmesh;

namespace {

struct Pair {
  Placement first, second;
};

/// Random pairs with their centres `nearest` to `furthest` apart, those that lie apart with a gap below
/// `below`.
std::vector<Pair> apartPairs(const MeshHierarchy& cell, double nearest, double furthest, double below,
                             int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(0.0, 100.0), distance(nearest, furthest);
  std::vector<Pair> pairs;
  while (static_cast<int>(pairs.size()) < count) {
    const Vec3 at(coordinate(random), coordinate(random), coordinate(random));
    const Mat3 one = test::randomRotation(random), other = test::randomRotation(random);
    const Pair pair = {{one, at}, {other, at + distance(random) * test::randomDirection(random)}};
    const MeshPairResult result = relate(cell, pair.first, cell, pair.second, below < 1e3 ? below : 0.0);
    if (result.relation == MeshRelation::apart && (below > 1e3 || result.gap < below)) pairs.push_back(pair);
  }
  return pairs;
}

/// Arguments: distances of centres and gaps kept in tenths of a µm, gap of interest in hundredths.
void relateRedCells(benchmark::State& state) {
  const MeshHierarchy cell(test::redCell());
  const std::vector<Pair> pairs =
      apartPairs(cell, 0.1 * state.range(0), 0.1 * state.range(1), 0.1 * state.range(2), 2000);
  std::size_t i = 0;
  for (auto _ : state) {
    const Pair& pair = pairs[i++ % pairs.size()];
    benchmark::DoNotOptimize(relate(cell, pair.first, cell, pair.second, 0.01 * state.range(3)));
  }
}

}  // namespace

BENCHMARK(relateRedCells)
    ->ArgNames({"from", "to", "gapBelow", "interest"})
    ->Args({25, 75, 100000, 0})    // all that lie apart
    ->Args({25, 75, 1, 0})         // touching ones
    ->Args({25, 45, 100000, 0})    // nested and stacked ones
    ->Args({25, 75, 100000, 2})    // with the gap as a certificate asks for it, once some small gap is known
    ->Args({25, 75, 100000, 100})  // with every gap below a micrometre
    ->Unit(benchmark::kMicrosecond);

BENCHMARK_MAIN();
