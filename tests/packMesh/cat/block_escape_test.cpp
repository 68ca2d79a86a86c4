// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/block_escape.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <random>

using namespace packmesh;

namespace {

double sumOf(const std::vector<std::vector<double>>& scores, const std::vector<int>& columns) {
  double sum = 0.0;
  for (std::size_t r = 0; r < columns.size(); ++r) sum += scores[r][columns[r]];
  return sum;
}

double bestByTrying(const std::vector<std::vector<double>>& scores) {
  std::vector<int> columns(scores.size());
  std::iota(columns.begin(), columns.end(), 0);
  double best = sumOf(scores, columns);
  while (std::next_permutation(columns.begin(), columns.end())) best = std::max(best, sumOf(scores, columns));
  return best;
}

}  // namespace

TEST_CASE("The best assignment is the best of all permutations") {
  std::mt19937 random(5);
  for (int n = 1; n <= 7; ++n) {
    for (int trial = 0; trial < 40; ++trial) {
      // Few different values, so that there are ties.
      std::uniform_int_distribution<int> few(-3, 3);
      std::uniform_real_distribution<double> many(-5.0, 5.0);
      std::vector<std::vector<double>> scores(n, std::vector<double>(n));
      for (auto& row : scores)
        for (double& s : row) s = trial % 2 == 0 ? few(random) : many(random);
      const std::vector<int> columns = bestAssignment(scores);
      REQUIRE(columns.size() == scores.size());
      std::vector<int> sorted = columns;
      std::sort(sorted.begin(), sorted.end());
      for (int c = 0; c < n; ++c) REQUIRE(sorted[c] == c);
      REQUIRE(sumOf(scores, columns) == Approx(bestByTrying(scores)).margin(1e-9));
    }
  }
}

TEST_CASE("The assignment of an empty matrix is empty") {
  CHECK(bestAssignment({}).empty());
}
