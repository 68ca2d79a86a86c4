// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/neighbor_list.h"
#include "packMesh/parallel/blocks.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

/// A pair by ids, whichever way round it was found: (first id, second id, shift of the second).
using Key = std::tuple<std::int64_t, std::int64_t, int, int, int>;

struct Scene {
  Box bounds;
  Vec3 period;
  double margin;
  std::vector<double> radii;
  std::vector<Body> bodies;
  BlockGrid blocks;
};

Scene randomScene(unsigned seed, int count, double largestRadius, double size) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Box bounds;
  bounds.lo = Vec3(-3.0, 10.0, 0.0);
  bounds.hi = bounds.lo + size * Vec3(1.0, 0.7 + 0.6 * unit(random), 0.5 + unit(random));
  Vec3 period;
  for (int k = 0; k < 3; ++k) period[k] = seed % 8 >> k & 1 ? 0.0 : bounds.size()[k];
  const double margin = 0.5 * unit(random);
  Scene scene{bounds, period,
              margin, {largestRadius, 0.3 * largestRadius},
              {},     BlockGrid(bounds, period, 2.0 * largestRadius + margin, 0.0)};
  for (int i = 0; i < count; ++i) {
    Body b;
    b.id = 3 * i + 1;
    b.shape = int(random() % 2);
    b.scale = random() % 3 == 0 ? 0.5 : 1.0;
    b.position = bounds.lo + bounds.size().cwiseProduct(Vec3(unit(random), unit(random), unit(random)));
    b.block = scene.blocks.blockOf(b.position);
    scene.bodies.push_back(b);
  }
  std::sort(scene.bodies.begin(), scene.bodies.end(),
            [](const Body& a, const Body& b) { return std::tie(a.block, a.id) < std::tie(b.block, b.id); });
  return scene;
}

std::vector<std::int64_t> initialCells(const Scene& s) {
  std::vector<std::int64_t> start(s.blocks.count() + 1, 0);
  for (const Body& body : s.bodies) ++start[body.block + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  return start;
}

PairList list(const Scene& s, const Threads& threads = {}) {
  const std::vector<std::int64_t> start = initialCells(s);
  std::vector<int> all(s.blocks.count());
  std::iota(all.begin(), all.end(), 0);
  PairList list(all.size());
  PairLister({s.bodies, start, s.radii, s.margin, s.bounds, s.period}).list(all, threads, list);
  return list;
}

std::vector<Key> keys(const Scene& s, const PairList& pairs) {
  std::vector<Key> out;
  for (const std::vector<ContactPair>& ofBlock : pairs)
    for (const ContactPair& p : ofBlock) {
      Key key{s.bodies[p.first].id, s.bodies[p.second].id, p.shift[0], p.shift[1], p.shift[2]};
      if (p.first == p.second &&
          p.shift < ImageShift{0, 0, 0})  // a cell and its image, seen from the other side
        key = {s.bodies[p.first].id, s.bodies[p.second].id, -p.shift[0], -p.shift[1], -p.shift[2]};
      out.push_back(key);
    }
  return out;
}

std::set<Key> bruteForce(const Scene& s) {
  std::set<Key> out;
  int most[3];
  for (int k = 0; k < 3; ++k)
    most[k] = s.period[k] > 0.0 ? 1 + int((2.0 * s.radii[0] + s.margin) / s.period[k]) : 0;
  for (const Body& a : s.bodies)
    for (const Body& b : s.bodies) {
      if (a.id > b.id) continue;
      for (int z = -most[2]; z <= most[2]; ++z)
        for (int y = -most[1]; y <= most[1]; ++y)
          for (int x = -most[0]; x <= most[0]; ++x) {
            if (a.id == b.id && std::make_tuple(x, y, z) <= std::make_tuple(0, 0, 0)) continue;
            const Vec3 image = b.position + Vec3(x, y, z).cwiseProduct(s.period);
            if ((a.position - image).norm() <
                s.radii[a.shape] * a.scale + s.radii[b.shape] * b.scale + s.margin)
              out.insert({a.id, b.id, x, y, z});
          }
    }
  return out;
}

}  // namespace

TEST_CASE("Pairs agree with brute force over all images, without repetition", "[relaxation]") {
  std::size_t total = 0, ownImages = 0;
  for (unsigned seed = 0; seed < 48; ++seed) {
    CAPTURE(seed);
    // Roomy, dense, and with periods below a cell's radius.
    const double size = seed < 16 ? 30.0 : seed < 32 ? 12.0 : 2.5;
    const Scene scene = randomScene(seed, seed < 32 ? 80 : 6, 2.0, size);
    const std::vector<Key> found = keys(scene, list(scene));
    const std::set<Key> distinct(found.begin(), found.end());
    REQUIRE(distinct.size() == found.size());
    REQUIRE(distinct == bruteForce(scene));
    total += found.size();
    for (const Key& k : found) ownImages += std::get<0>(k) == std::get<1>(k);
  }
  REQUIRE(total > 3000);
  REQUIRE(ownImages > 50);
}

TEST_CASE("Pairs are stored at the block of the smaller id, in order of ids and shifts", "[relaxation]") {
  for (unsigned seed = 0; seed < 16; ++seed) {
    const Scene s = randomScene(seed, 120, 1.5, 25.0);
    const PairList pairs = list(s);
    REQUIRE(pairs.size() == std::size_t(s.blocks.count()));
    for (int b = 0; b < s.blocks.count(); ++b)
      for (std::size_t p = 0; p < pairs[b].size(); ++p) {
        const ContactPair& pair = pairs[b][p];
        REQUIRE(s.bodies[pair.first].id <= s.bodies[pair.second].id);
        REQUIRE(s.bodies[pair.first].block == b);
        REQUIRE(pair.apartUntil < 0.0);
        REQUIRE(pair.extraClearance == 0.0f);
        if (p == 0) continue;
        const ContactPair& before = pairs[b][p - 1];
        REQUIRE(std::make_tuple(s.bodies[before.first].id, s.bodies[before.second].id, before.shift) <
                std::make_tuple(s.bodies[pair.first].id, s.bodies[pair.second].id, pair.shift));
      }
  }
}

TEST_CASE("Several threads list the pairs that one lists", "[relaxation][threads]") {
  for (unsigned seed = 0; seed < 8; ++seed) {
    const Scene s = randomScene(seed, 200, 1.0, 25.0);
    REQUIRE(keys(s, list(s, Threads(3))) == keys(s, list(s)));
  }
}

TEST_CASE("There are no pairs without cells or with one cell in a large period", "[relaxation]") {
  const Box bounds{{0, 0, 0}, {20, 20, 20}};
  const std::vector<double> radii = {1.0};
  for (const std::vector<Body>& bodies : {std::vector<Body>(), std::vector<Body>(1)}) {
    const std::vector<std::int64_t> start = {0, std::int64_t(bodies.size())};
    PairList list(1);
    PairLister({bodies, start, radii, 0.1, bounds, bounds.size()}).list({0}, {}, list);
    REQUIRE(list[0].empty());
  }
}

TEST_CASE("Pairs of some blocks can be listed later, at the positions of the beginning", "[relaxation]") {
  Scene s = randomScene(3, 200, 1.5, 25.0);
  const PairList all = list(s);
  const std::vector<std::int64_t> start = initialCells(s);
  const PairLister search({s.bodies, start, s.radii, s.margin, s.bounds, s.period});
  for (Body& body : s.bodies) body.position.x() += 3.0;
  PairList some(all.size());
  const std::vector<int> later = {2, 0};
  search.list(later, {}, some);
  for (int b = 0; b < s.blocks.count(); ++b) {
    const bool listed = b == 0 || b == 2;
    REQUIRE(some[b].size() == (listed ? all[b].size() : 0));
    for (std::size_t p = 0; p < some[b].size(); ++p) REQUIRE(some[b][p].second == all[b][p].second);
  }
}
