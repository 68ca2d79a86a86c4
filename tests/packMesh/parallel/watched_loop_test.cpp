// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/watched_loop.h"

#include <catch2/catch.hpp>
#include <stdexcept>
#include <thread>
#include <vector>

using namespace packmesh;

TEST_CASE("A watched loop does every item once", "[parallel]") {
  const std::function<bool()> never;
  for (const int count : {1, 2, 5})
    for (const std::int64_t items : {0, 1, 3, 100}) {
      WatchedLoop loop(Threads(count), never);
      std::vector<std::atomic<int>> done(items);
      std::atomic<bool> wrong{false};
      loop.forEach(items, [&](std::int64_t item, int thread) {
        if (thread < 0 || thread >= count || loop.stops(thread)) wrong = true;
        ++done[item];
      });
      REQUIRE(!wrong);
      for (const std::atomic<int>& times : done) REQUIRE(times == 1);
    }
}

TEST_CASE("Only the first thread asks whether a watched loop is to stop, also while others alone have items",
          "[parallel]") {
  std::atomic<bool> otherWaits{false};
  const std::thread::id first = std::this_thread::get_id();
  bool byFirst = true;
  const std::function<bool()> interrupted = [&] {
    byFirst = byFirst && std::this_thread::get_id() == first;
    return otherWaits.load();
  };
  WatchedLoop loop(Threads(2), interrupted);
  std::atomic<int> taken{0};
  loop.forEach(2, [&](std::int64_t, int thread) {
    // Both threads have an item; that of the other one ends when the loop is stopped.
    ++taken;
    while (taken < 2) std::this_thread::yield();
    if (thread == 0) return;
    otherWaits = true;
    while (!loop.stops(thread)) std::this_thread::yield();
  });
  REQUIRE(otherWaits);
  REQUIRE(byFirst);
}

TEST_CASE("What an item of a watched loop throws arrives, and others end", "[parallel]") {
  const std::function<bool()> never;
  for (const int count : {1, 3}) {
    WatchedLoop loop(Threads(count), never);
    REQUIRE_THROWS_AS(loop.forEach(20,
                                   [](std::int64_t item, int) {
                                     if (item == 4) throw std::runtime_error("four");
                                   }),
                      std::runtime_error);
  }
}
