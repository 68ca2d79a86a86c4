// SPDX-License-Identifier: AGPL-3.0-or-later
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "packMesh/parallel/threads.h"
#include "tests/support/catch.h"

using namespace packmesh;

TEST_CASE("Threads do every item of a loop once", "[parallel][threads]") {
  for (const int count : {1, 2, 3, 8}) {
    const Threads threads = count == 1 ? Threads() : Threads(count);
    REQUIRE(threads.count() == count);
    for (const std::int64_t items : {0, 1, 2, 7, 1000}) {
      CAPTURE(count, items);
      std::vector<std::atomic<int>> done(items);
      std::vector<std::int64_t> byThread(count, 0);
      threads.forEach(items, [&](std::int64_t item, int thread) {
        ++done[item];
        ++byThread[thread];
      });
      std::int64_t sum = 0;
      for (const std::int64_t some : byThread) sum += some;
      REQUIRE(sum == items);
      for (const std::atomic<int>& times : done) REQUIRE(times == 1);
    }
  }
}

TEST_CASE("Parts of a loop cover its items without overlap", "[parallel][threads]") {
  const Threads threads(3);
  for (const std::int64_t items : {0, 1, 9, 10, 11, 95}) {
    std::vector<std::atomic<int>> done(items);
    threads.forEachPart(
        items,
        [&](std::int64_t begin, std::int64_t end, int) {
          for (std::int64_t i = begin; i < end; ++i) ++done[i];
        },
        10);
    for (const std::atomic<int>& times : done) REQUIRE(times == 1);
  }
}

TEST_CASE("Threads are started when there are items for them", "[parallel][threads]") {
  const auto running = [] {
    const std::filesystem::directory_iterator tasks("/proc/self/task");
    return std::distance(begin(tasks), end(tasks));
  };
  const auto before = running();
  const Threads threads(1000);
  REQUIRE(threads.count() == 1000);
  REQUIRE(running() == before);
  std::atomic<int> done{0};
  const auto loop = [&](std::int64_t items) {
    done = 0;
    threads.forEach(items, [&](std::int64_t, int) { ++done; });
    REQUIRE(done == items);
  };
  loop(1);
  REQUIRE(running() == before);
  loop(3);
  REQUIRE(running() == before + 2);
  for (const std::int64_t items : {2, 5, 4, 1, 5}) loop(items);
  REQUIRE(running() == before + 4);
}

TEST_CASE("Items that wait for each other have a thread each", "[parallel][threads]") {
  REQUIRE(Threads().atOnce() == 1);
  for (const int count : {2, 5}) {
    const Threads threads(count);
    const int items = threads.atOnce();
    REQUIRE(items == std::min(count, availableCores()));
    std::atomic<int> begun{0};
    threads.forEach(items, [&](std::int64_t, int) {
      ++begun;
      while (begun < items) std::this_thread::yield();
    });
    REQUIRE(begun == items);
  }
}

TEST_CASE("Each of many loops sees what the one before has written", "[parallel][threads]") {
  const Threads threads(4);
  std::vector<int> values(64, 0);
  for (int loop = 0; loop < 2000; ++loop) {
    const std::vector<int> before = values;
    threads.forEach(64, [&](std::int64_t i, int) { values[i] = before[(i + 1) % 64] + 1; });
    for (int i = 0; i < 64; ++i) REQUIRE(values[i] == before[(i + 1) % 64] + 1);
  }
}

TEST_CASE("The exception of the smallest item that fails is thrown, and the threads go on",
          "[parallel][threads]") {
  const Threads threads(3);
  for (int repeat = 0; repeat < 50; ++repeat) {
    std::string message;
    try {
      threads.forEach(100, [](std::int64_t item, int) {
        if (item % 10 == 7) throw std::runtime_error(std::to_string(item));
      });
    } catch (const std::runtime_error& error) {
      message = error.what();
    }
    REQUIRE(message == "7");
  }
  std::atomic<int> done{0};
  threads.forEach(100, [&](std::int64_t, int) { ++done; });
  REQUIRE(done == 100);
}

TEST_CASE("Copies share the threads", "[parallel][threads]") {
  Threads copy;
  REQUIRE(copy.alone());
  {
    const Threads threads(2);
    copy = threads;
  }
  std::atomic<int> done{0};
  copy.forEach(10, [&](std::int64_t, int) { ++done; });
  REQUIRE(done == 10);
  REQUIRE(copy.count() == 2);
}

TEST_CASE("A forked process does loops alone", "[parallel]") {
  const Threads threads(3);
  const pid_t child = fork();
  if (child == 0) {
    int done = 0;
    threads.forEach(10, [&](std::int64_t, int) { ++done; });
    _exit(done == 10 && threads.atOnce() == 1 ? 0 : 1);
  }
  int status = 1;
  REQUIRE(waitpid(child, &status, 0) == child);
  REQUIRE(status == 0);
}

TEST_CASE("Values that several threads need are the same for all of them", "[parallel][threads]") {
  MadeOnce<int, std::string> texts;
  const Threads threads(4);
  std::vector<const std::string*> found(1000);
  threads.forEach(1000, [&](std::int64_t i, int) {
    const int key = int(i % 17);
    found[i] = &texts.at(key, [&] { return std::to_string(key); });
  });
  REQUIRE(texts.size() == 17);
  for (int i = 0; i < 1000; ++i) {
    REQUIRE(found[i] == found[i % 17]);
    REQUIRE(*found[i] == std::to_string(i % 17));
  }
}

TEST_CASE("Each thread has a value of its own, far from those of the others", "[parallel][threads]") {
  const Threads threads(3);
  PerThread<std::int64_t> sums(threads, 1);
  threads.forEach(1000, [&](std::int64_t i, int thread) { sums[thread] += i; });
  std::int64_t all = 0;
  int count = 0;
  sums.forEach([&](std::int64_t sum) { all += sum, ++count; });
  REQUIRE(count == 3);
  REQUIRE(all == 999 * 1000 / 2 + 3);
  REQUIRE(reinterpret_cast<char*>(&sums[1]) - reinterpret_cast<char*>(&sums[0]) >= 128);
}

TEST_CASE("There is at least one core", "[parallel][threads]") {
  REQUIRE(availableCores() >= 1);
}

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
