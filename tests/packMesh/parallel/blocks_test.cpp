// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/blocks.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

struct Domain {
  Box bounds;
  Vec3 period;
  double range, edge;
};

Domain randomDomain(std::mt19937& random) {
  std::uniform_real_distribution<double> size(3.0, 90.0), corner(-50.0, 50.0), range(1.0, 6.0),
      edge(0.0, 20.0);
  Domain d;
  d.bounds.lo = Vec3(corner(random), corner(random), corner(random));
  const Vec3 extent(size(random), size(random), size(random));
  d.bounds.hi = d.bounds.lo + extent;
  for (int k = 0; k < 3; ++k) d.period[k] = random() % 2 ? extent[k] : 0.0;
  d.range = range(random);
  d.edge = edge(random);
  return d;
}

Vec3 randomPoint(const Box& box, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  return box.lo + box.size().cwiseProduct(Vec3(unit(random), unit(random), unit(random)));
}

}  // namespace

TEST_CASE("Blocks are at least two ranges wide, and one or an even number along periodic axes",
          "[distributed]") {
  std::mt19937 random(1);
  for (int n = 0; n < 300; ++n) {
    const Domain d = randomDomain(random);
    const BlockGrid grid(d.bounds, d.period, d.range, d.edge);
    REQUIRE(grid.count() == grid.counts()[0] * grid.counts()[1] * grid.counts()[2]);
    for (int k = 0; k < 3; ++k) {
      const int blocks = grid.counts()[k];
      REQUIRE(blocks >= 1);
      if (blocks > 1) REQUIRE(d.bounds.size()[k] / blocks >= std::max(2.0 * d.range, d.edge) * (1.0 - 1e-12));
      if (d.period[k] > 0.0) REQUIRE((blocks == 1 || blocks % 2 == 0));
      // As many as fit, but for the evenness.
      REQUIRE(d.bounds.size()[k] / (blocks + 2) < std::max(2.0 * d.range, d.edge));
    }
  }
  REQUIRE(BlockGrid(Box{{0, 0, 0}, {50, 50, 50}}, Vec3(50, 50, 0), 5.0, 10.0).counts() ==
          std::array<int, 3>{4, 4, 5});
}

TEST_CASE("The number of blocks is limited for any size of domain and cells", "[distributed]") {
  const Box metre{Vec3::Zero(), Vec3::Constant(1e6)};
  const BlockGrid many(metre, metre.size(), 1e-3, 0.0);
  REQUIRE(many.count() == 1000 * 1000 * 1000);
  REQUIRE(many.blockOf(Vec3::Constant(1e6)) == many.count() - 1);
  // No cells at all have no range.
  REQUIRE(BlockGrid(metre, Vec3::Zero(), 0.0, 0.0).count() == 1);
}

TEST_CASE("Every point has a block, and points outside have that of the nearest point inside",
          "[distributed]") {
  std::mt19937 random(2);
  for (int n = 0; n < 100; ++n) {
    const Domain d = randomDomain(random);
    const BlockGrid grid(d.bounds, d.period, d.range, d.edge);
    const auto counts = grid.counts();
    std::set<int> seen;
    for (int i = 0; i < 100; ++i) {
      const Vec3 p = randomPoint(d.bounds.grownBy(30.0), random);
      const int block = grid.blockOf(p);
      REQUIRE((block >= 0 && block < grid.count()));
      const Vec3 inside = p.cwiseMax(d.bounds.lo).cwiseMin(d.bounds.hi);
      REQUIRE(block == grid.blockOf(inside));
      const int index[3] = {block % counts[0], block / counts[0] % counts[1], block / counts[0] / counts[1]};
      for (int k = 0; k < 3; ++k) {
        const double edge = d.bounds.size()[k] / counts[k];
        REQUIRE(inside[k] >= d.bounds.lo[k] + index[k] * edge - 1e-9);
        REQUIRE(inside[k] <= d.bounds.lo[k] + (index[k] + 1) * edge + 1e-9);
      }
    }
  }
}

TEST_CASE("Blocks that touch, also across a periodic face, differ in colour", "[distributed]") {
  std::mt19937 random(3);
  for (int n = 0; n < 100; ++n) {
    const Domain d = randomDomain(random);
    const BlockGrid grid(d.bounds, d.period, d.range, d.edge);
    const auto c = grid.counts();
    const auto number = [&](int i, int j, int k) { return i + c[0] * (j + c[1] * k); };
    for (int b = 0; b < grid.count(); ++b) {
      REQUIRE((grid.colourOf(b) >= 0 && grid.colourOf(b) < BlockGrid::colours));
      const int at[3] = {b % c[0], b / c[0] % c[1], b / c[0] / c[1]};
      for (int step = 0; step < 27; ++step) {
        int other[3] = {at[0] + step % 3 - 1, at[1] + step / 3 % 3 - 1, at[2] + step / 9 - 1};
        bool exists = true;
        for (int k = 0; k < 3; ++k) {
          if (d.period[k] > 0.0) other[k] = (other[k] + c[k]) % c[k];
          exists &= other[k] >= 0 && other[k] < c[k];
        }
        if (!exists) continue;
        const int neighbour = number(other[0], other[1], other[2]);
        if (neighbour != b) REQUIRE(grid.colourOf(neighbour) != grid.colourOf(b));
      }
    }
  }
}

TEST_CASE("Changes by two blocks of one colour never overlap", "[distributed]") {
  // Cells of a block, and cells within the range of them, against those of every other block of its colour.
  std::mt19937 random(4);
  for (int n = 0; n < 30; ++n) {
    const Domain d = randomDomain(random);
    const BlockGrid grid(d.bounds, d.period, d.range, d.edge);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (int i = 0; i < 2000; ++i) {
      const Vec3 p = randomPoint(d.bounds, random);
      // Two cells that both act on one at p, from blocks of one colour.
      Vec3 q[2];
      for (Vec3& point : q) {
        do point = Vec3(unit(random), unit(random), unit(random));
        while (point.norm() > 1.0);
        point = wrapped(p + 0.999 * d.range * point, d.bounds, d.period);
      }
      if (!d.bounds.contains(q[0]) || !d.bounds.contains(q[1])) continue;
      const int one = grid.blockOf(q[0]), other = grid.blockOf(q[1]);
      if (one != other) REQUIRE(grid.colourOf(one) != grid.colourOf(other));
    }
  }
}

TEST_CASE("The distance of a block one step away is that of its nearest point", "[distributed]") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const Box bounds{Vec3(1, -2, 3), Vec3(61, 28, 25)};
  for (const Vec3& period : {Vec3(0, 0, 0), Vec3(60, 0, 22), Vec3(60, 30, 22)}) {
    const BlockGrid grid(bounds, period, 1.0, 10.0);
    for (int n = 0; n < 300; ++n) {
      const Vec3 p = bounds.lo + Vec3(unit(random), unit(random), unit(random)).cwiseProduct(bounds.size());
      const int block = grid.blockOf(p);
      int seen = 0;
      for (const BlockGrid::Neighbor& neighbor : grid.neighbors(block)) {
        Vec3 nearest;  // point of the box one step away
        for (int k = 0; k < 3; ++k) {
          const double edge = bounds.size()[k] / grid.counts()[k];
          const double low = bounds.lo[k] + (grid.indexOf(block)[k] + neighbor.step[k]) * edge;
          nearest[k] = std::clamp(p[k], low, low + edge);
          int index = grid.indexOf(block)[k] + neighbor.step[k];
          if (period[k] > 0.0) index = (index + grid.counts()[k]) % grid.counts()[k];
          REQUIRE(index == grid.indexOf(neighbor.block)[k]);
        }
        REQUIRE(BlockGrid::squaredDistance(grid.faceDistances(p, block), neighbor.step) ==
                Approx((nearest - p).squaredNorm()).margin(1e-9));
        ++seen;
      }
      REQUIRE(seen >= 7);
      if (period[0] > 0.0 && period[1] > 0.0) REQUIRE(seen == 26);
    }
  }
}

TEST_CASE("Blocks around a block are those that touch it", "[distributed]") {
  for (const Vec3& periodic : {Vec3(0, 0, 0), Vec3(1, 0, 1), Vec3(1, 1, 1)}) {
    const Vec3 size(6, 4, 2);
    const BlockGrid grid({Vec3::Zero(), size}, periodic.cwiseProduct(size), 0.5, 1.0);
    const auto touch = [&](int a, int b) {
      for (int k = 0; k < 3; ++k) {
        const int n = grid.counts()[k], d = std::abs(grid.indexOf(a)[k] - grid.indexOf(b)[k]);
        if (d > 1 && !(periodic[k] > 0.0 && d == n - 1)) return false;
      }
      return true;
    };
    for (int a = 0; a < grid.count(); ++a) {
      std::set<int> blocks;
      for (int b = 0; b < grid.count(); ++b)
        if (touch(a, b)) blocks.insert(b);
      REQUIRE(grid.around(a) == std::vector<int>(blocks.begin(), blocks.end()));
    }
  }
}

TEST_CASE("wrapped() moves points into one period, and forEachImage finds all near images", "[distributed]") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> reachOf(0.1, 30.0);
  for (int n = 0; n < 200; ++n) {
    const Domain d = randomDomain(random);
    const Vec3 p = randomPoint(d.bounds.grownBy(200.0), random), w = wrapped(p, d.bounds, d.period);
    for (int k = 0; k < 3; ++k) {
      if (d.period[k] == 0.0) {
        REQUIRE(w[k] == p[k]);
        continue;
      }
      REQUIRE((w[k] >= d.bounds.lo[k] && w[k] < d.bounds.hi[k]));
      const double periods = (p[k] - w[k]) / d.period[k];
      REQUIRE(periods == Approx(std::round(periods)).margin(1e-9));
    }
    const Vec3 inside = randomPoint(d.bounds, random);
    const double reach = reachOf(random);
    std::set<ImageShift> found, expected;
    forEachImage(inside, reach, d.bounds, d.period,
                 [&](const ImageShift& s) { REQUIRE(found.insert(s).second); });
    const auto most = [&](int k) { return d.period[k] > 0.0 ? 12 : 0; };
    for (int z = -most(2); z <= most(2); ++z)
      for (int y = -most(1); y <= most(1); ++y)
        for (int x = -most(0); x <= most(0); ++x) {
          const ImageShift s{std::int8_t(x), std::int8_t(y), std::int8_t(z)};
          if (d.bounds.grownBy(reach).contains(inside + displacement(s, d.period))) expected.insert(s);
        }
    REQUIRE(found == expected);
  }
  const Box unitBox{{0, 0, 0}, {1, 1, 1}};
  REQUIRE(wrapped(Vec3(-1e-30, 0, 0), unitBox, Vec3::Ones()).x() == 0.0);
}

namespace {

BlockGrid gridOf(int x, int y, int z, const Vec3& periodic) {
  const Vec3 size(x, y, z);
  return {{Vec3::Zero(), size}, periodic.cwiseProduct(size), 0.5, 1.0};
}

}  // namespace

TEST_CASE("Equal work is distributed equally, and empty blocks cost nothing", "[distributed]") {
  std::mt19937 random(1);
  for (const int ranks : {1, 2, 3, 7, 16}) {
    const BlockGrid grid = gridOf(12, 10, 8, Vec3::Ones());
    std::vector<std::int64_t> work(grid.count());
    for (std::int64_t& w : work) w = random() % 3 == 0 ? 90 + random() % 20 : 0;  // a vessel in its box
    const BlockOwners owners(grid, work, ranks);
    std::vector<std::int64_t> ofRank(ranks, 0);
    for (int b = 0; b < grid.count(); ++b) {
      REQUIRE(owners.of(b) >= 0);
      REQUIRE(owners.of(b) < ranks);
      ofRank[owners.of(b)] += work[b];
    }
    const double even = double(std::accumulate(work.begin(), work.end(), std::int64_t(0))) / ranks;
    CAPTURE(ranks, even, ofRank);
    REQUIRE(*std::max_element(ofRank.begin(), ofRank.end()) < even + 110);
    REQUIRE(*std::min_element(ofRank.begin(), ofRank.end()) > even - 110);
  }
}

TEST_CASE("Some ranks are idle if there are more ranks than blocks", "[distributed]") {
  const BlockGrid grid = gridOf(2, 1, 1, Vec3::Zero());
  const BlockOwners owners(grid, {5, 7}, 8);
  REQUIRE(owners.of(0) != owners.of(1));
  const BlockOwners none(grid, {0, 0}, 8);
  REQUIRE(none.of(0) == none.of(1));
}
