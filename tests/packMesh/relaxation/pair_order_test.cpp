// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/neighbor_list.h"
#include "tests/support/catch.h"

#include <thread>

using namespace packmesh;

namespace {

/// Bodies anywhere in a cube and pairs between any of them, some of a body with itself.
struct OrderedScene {
  std::vector<Body> bodies;
  std::vector<ContactPair> pairs;
};

OrderedScene randomScene(unsigned seed, int bodies, int pairs) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  OrderedScene scene;
  scene.bodies.resize(bodies);
  for (Body& body : scene.bodies) body.position = {unit(random), unit(random), unit(random)};
  for (int k = 0; k < pairs; ++k) {
    const auto any = [&] { return std::int32_t(random() % bodies); };
    const auto [first, second] = std::minmax({any(), any()});
    scene.pairs.push_back({first, second, {0, 0, 0}});
  }
  return scene;
}

}  // namespace

TEST_CASE("A thread that waits in vain leaves the rest to one thread", "[relaxation]") {
  const OrderedScene scene = randomScene(1, 50, 1000);
  PairOrder order(scene.pairs, scene.bodies, 0, 50, 4);
  for (int repeat = 0; repeat < 2; ++repeat) {
    std::vector<std::int32_t> pairs, bodies;
    const auto onPair = [&](std::int32_t pair, std::int32_t) { pairs.push_back(pair); };
    const auto onBody = [&](std::int32_t body) { bodies.push_back(body); };
    order.restart();
    REQUIRE_FALSE(order.isHeldUp());
    order.run(2, onPair, onBody);  // the other parts are not run
    REQUIRE(order.isHeldUp());
    REQUIRE(pairs.size() < 1000);
    order.finish(onPair, onBody);
    const auto isEveryOne = [](std::vector<std::int32_t> indices, std::size_t count) {
      std::sort(indices.begin(), indices.end());
      for (std::size_t k = 0; k < indices.size(); ++k)
        if (indices[k] != std::int32_t(k)) return false;
      return indices.size() == count;
    };
    REQUIRE(isEveryOne(pairs, 1000));
    REQUIRE(isEveryOne(bodies, 50));
  }
}

TEST_CASE("Threads resolve the pairs of every body in the order of the list", "[relaxation]") {
  for (const int parts : {1, 2, 3, 8})
    for (const int pairs : {0, 1, 40, 4000}) {
      CAPTURE(parts, pairs);
      const OrderedScene scene = randomScene(pairs + parts, 100, pairs);
      const std::int64_t begin = 20, end = 90;
      PairOrder order(scene.pairs, scene.bodies, begin, end, parts);
      REQUIRE(order.parts() == parts);
      std::vector<std::vector<std::int32_t>> expected(scene.bodies.size());
      for (std::int32_t k = 0; k < pairs; ++k) {
        expected[scene.pairs[k].first].push_back(k);
        if (scene.pairs[k].first != scene.pairs[k].second) expected[scene.pairs[k].second].push_back(k);
      }
      for (std::int32_t i = begin; i < end; ++i) expected[i].push_back(pairs);  // the body itself

      for (int repeat = 0; repeat < 20; ++repeat) {
        std::vector<std::vector<std::int32_t>> met(scene.bodies.size());
        order.restart();
        const auto onPair = [&](std::int32_t pair, std::int32_t) {
          met[scene.pairs[pair].first].push_back(pair);
          if (scene.pairs[pair].first != scene.pairs[pair].second)
            met[scene.pairs[pair].second].push_back(pair);
        };
        const auto onBody = [&](std::int32_t body) { met[body].push_back(pairs); };
        std::vector<std::thread> threads;
        for (int part = 0; part < parts; ++part)
          threads.emplace_back([&, part] { order.run(part, onPair, onBody); });
        for (std::thread& thread : threads) thread.join();
        order.finish(onPair, onBody);
        REQUIRE(met == expected);
      }
    }
}
