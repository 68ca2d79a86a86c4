// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/overlap_search.h"

#include <catch2/catch.hpp>
#include <numeric>
#include <vector>

using namespace packmesh;

namespace {

struct Course {
  std::int64_t pairs = 0;  ///< listed
  std::int64_t work = 0;   ///< pairs found, listed or forgotten
  int rounds = 0;
  bool more = false;
};

/// The course of a search in which each cell has so many pairs; of examples it has five at most.
Course courseOf(const std::vector<std::int64_t>& pairs, std::int64_t most) {
  Course course;
  OverlapSearch search(std::int64_t(pairs.size()), most);
  while (!search.over()) {
    std::int64_t found = 0;
    for (std::int64_t i = search.begin(); i < search.end(); ++i)
      found += search.more() ? std::min<std::int64_t>(pairs[i], 5) : pairs[i];
    found = std::min(found, search.room());
    course.work += found;
    ++course.rounds;
    if (search.finish(found)) course.pairs += found;
  }
  course.more = search.more();
  return course;
}

}  // namespace

TEST_CASE("A search below its limit lists all pairs in a few rounds", "[overlap_search]") {
  const std::vector<std::int64_t> pairs(1000, 3);
  const Course course = courseOf(pairs, 3001);
  CHECK(course.pairs == 3000);
  CHECK_FALSE(course.more);
  CHECK(course.rounds == 10);
  CHECK(courseOf({}, 10).rounds == 0);
}

TEST_CASE("A search at its limit ends soon, with some examples, wherever the pairs are", "[overlap_search]") {
  constexpr std::int64_t most = 100000;
  std::vector<std::int64_t> pairs(1 << 20, 0);
  SECTION("all cells") {
    std::fill(pairs.begin(), pairs.end(), pairs.size());
  }
  SECTION("the last cell") {
    pairs.back() = most;
  }
  SECTION("the second half") {
    std::fill(pairs.begin() + pairs.size() / 2, pairs.end(), most);
  }
  SECTION("every other cell") {
    for (std::size_t i = 0; i < pairs.size(); i += 2) pairs[i] = most;
  }
  SECTION("a pair per cell") {
    std::fill(pairs.begin(), pairs.end(), 1);
  }
  const Course course = courseOf(pairs, most);
  CHECK(course.more);
  CHECK(course.pairs >= 5);
  CHECK(course.pairs < most);
  CHECK(course.work <= 2 * most + 1000);
  CHECK(course.rounds < 1000);
}
