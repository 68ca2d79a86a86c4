// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/certificate.h"

#include "packMesh/certificate/certifier.h"
#include "packMesh/core/error.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "tests/packMesh/mesh/test_meshes.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

class PeriodicSpace : public Container {
 public:
  explicit PeriodicSpace(const Vec3& period) : period_(period) {}
  Box bounds() const override { return {Vec3::Zero(), period_}; }
  Vec3 period() const override { return period_; }
  double volume() const override { return period_.prod(); }
  const Wall* wall() const override { return nullptr; }
  std::string describe() const override { return "periodic space"; }
  TriangleMesh surface() const override { return {}; }

 private:
  Vec3 period_;
};

/// The half-space x > 0; counts how often vertices are looked at.
class HalfSpaceWall : public Wall {
 public:
  explicit HalfSpaceWall(double slack = 0.0) : slack_(slack) {}
  WallDistance distance(const Vec3& p) const override { return {p.x() + slack_, Vec3::UnitX()}; }
  double slack() const override { return slack_; }
  WallVerdict examine(const PlacedHierarchy& cell, double usualGapOfInterest) const override {
    ++asked;
    const Box box = boundingBox(placed(cell.hierarchy.mesh(), cell.placement));
    WallVerdict verdict;
    if (box.lo.x() <= 0.0)
      verdict.violation = box.hi.x() < 0.0 ? "is outside the lumen" : "meets the wall";
    else if (box.lo.x() < usualGapOfInterest)
      verdict.gap = box.lo.x();
    return verdict;
  }
  mutable int asked = 0;

 private:
  double slack_;
};

std::shared_ptr<const Shape> ball(double radius) {
  return std::make_shared<Shape>(test::icosphere(1, radius), ellipsoidProfile(radius, radius, radius));
}

struct Packing {
  std::vector<std::shared_ptr<const Shape>> shapes;
  std::vector<PlacedCell> cells;
  std::shared_ptr<const Container> container;
  std::vector<const Wall*> walls;

  CertificateInput input() const {
    CertificateInput in;
    for (const auto& shape : shapes) in.shapes.push_back(shape.get());
    in.walls = walls;
    in.walls.resize(shapes.size(), nullptr);
    in.container = container.get();
    in.cells = &cells;
    return in;
  }
};

using Key = std::tuple<std::int64_t, std::int64_t, double, double, double>;
std::map<Key, bool> keyed(const std::vector<OverlappingPair>& pairs) {
  std::map<Key, bool> out;
  for (const OverlappingPair& p : pairs)
    REQUIRE(out.emplace(Key{p.first, p.second, p.shift[0], p.shift[1], p.shift[2]}, p.contained).second);
  return out;
}

/// All pairs with all images that could matter, without any neighbour search.
/// @param reach no two cells interact whose centres differ by more than this along an axis, whichever image
/// [µm]
struct Expected {
  std::map<Key, bool> overlapping;
  double gap = infinite;
};
Expected bruteForce(const Packing& packing, const Vec3& period, double reach, double interest) {
  Expected out;
  const std::int64_t n = packing.cells.size();
  int images[3];
  for (int k = 0; k < 3; ++k) images[k] = period[k] > 0.0 ? int(std::ceil(reach / period[k])) : 0;
  for (std::int64_t i = 0; i < n; ++i)
    for (std::int64_t j = i; j < n; ++j)
      for (int x = -images[0]; x <= images[0]; ++x)
        for (int y = -images[1]; y <= images[1]; ++y)
          for (int z = -images[2]; z <= images[2]; ++z) {
            if (i == j && std::make_tuple(x, y, z) <= std::make_tuple(0, 0, 0)) continue;
            const PlacedCell &a = packing.cells[i], &b = packing.cells[j];
            Placement moved = b.placement;
            const Vec3 shift(x * period[0], y * period[1], z * period[2]);
            moved.translation += shift;
            const MeshPairResult r = relate(packing.shapes[a.shape]->hierarchy(), a.placement,
                                            packing.shapes[b.shape]->hierarchy(), moved, interest);
            if (r.relation != MeshRelation::apart)
              out.overlapping[Key{i, j, shift[0], shift[1], shift[2]}] = r.relation != MeshRelation::meet;
            else
              out.gap = std::min(out.gap, r.gap);
          }
  return out;
}

Packing randomPacking(unsigned seed, int count, const Vec3& period, double spread) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-spread, spread);
  Packing packing;
  packing.shapes = {
      ball(1.0),
      std::make_shared<Shape>(sample::torus(Vec3::Zero(), 1.5, 0.3, 8, 6), ellipsoidProfile(1.8, 1.8, 0.3)),
      ball(0.25)};
  packing.container = std::make_shared<PeriodicSpace>(period);
  for (int i = 0; i < count; ++i) {
    const int shape = int(random() % 3);
    packing.cells.push_back(
        {shape,
         shape,
         {test::randomRotation(random), Vec3(coordinate(random), coordinate(random), coordinate(random))}});
  }
  return packing;
}

}  // namespace

TEST_CASE("The certificate finds the same pairs and gap as brute force, with and without periods",
          "[certificate]") {
  int overlaps = 0, contained = 0, gaps = 0, ownImages = 0;
  for (const Vec3& period :
       {Vec3(0, 0, 0), Vec3(9, 0, 0), Vec3(8, 7, 9), Vec3(3, 11, 2.1), Vec3(1.3, 20, 20)})
    for (unsigned seed = 0; seed < 4; ++seed) {
      // Cells lie up to two periods outside of [0, period).
      const Packing packing = randomPacking(seed, seed % 2 ? 6 : 14, period, 4.0);
      const Expected expected = bruteForce(packing, period, 12.5, 0.6);  // 8 apart, radii of 1.8
      const Certificate certificate = certify(packing.input(), 0.6);
      REQUIRE(keyed(certificate.overlapping) == expected.overlapping);
      REQUIRE(certificate.clean() == expected.overlapping.empty());
      REQUIRE(certificate.minimumGap == (expected.overlapping.empty() ? expected.gap : 0.0));
      REQUIRE(std::is_sorted(certificate.overlapping.begin(), certificate.overlapping.end(),
                             [](const auto& a, const auto& b) {
                               return std::tie(a.first, a.second) < std::tie(b.first, b.second);
                             }));
      for (const OverlappingPair& p : certificate.overlapping) {
        ++overlaps;
        contained += p.contained;
        ownImages += p.first == p.second;
      }
      gaps += certificate.minimumGap > 0.0 && certificate.minimumGap < infinite;
    }
  REQUIRE(overlaps > 50);
  REQUIRE(contained > 0);
  REQUIRE(ownImages > 10);
}

TEST_CASE("The certificate finds the smallest gap of a sparse packing", "[certificate]") {
  int measured = 0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Vec3 period(12, 12, 12);
    Packing packing = randomPacking(seed, 30, period, 12.0);
    const Expected before = bruteForce(packing, period, 28.5, 0.6);
    std::vector<bool> drop(packing.cells.size(), false);
    for (const auto& [key, inside] : before.overlapping) drop[std::get<1>(key)] = true;
    Packing kept = packing;
    kept.cells.clear();
    for (std::size_t i = 0; i < drop.size(); ++i)
      if (!drop[i]) kept.cells.push_back(packing.cells[i]);
    const Expected expected = bruteForce(kept, period, 28.5, 0.6);
    const Certificate certificate = certify(kept.input(), 0.6);
    REQUIRE(certificate.clean());
    REQUIRE(certificate.minimumGap == expected.gap);
    measured += certificate.minimumGap < infinite;
    std::reverse(kept.cells.begin(), kept.cells.end());
    REQUIRE(certify(kept.input(), 0.6).minimumGap == Approx(expected.gap).epsilon(1e-12));
  }
  REQUIRE(measured > 6);
}

TEST_CASE("A cell meets its own image if the period is too short", "[certificate]") {
  Packing packing;
  packing.shapes = {std::make_shared<Shape>(sample::box({-1, -1, -1}, {1, 1, 1}), ellipsoidProfile(1, 1, 1))};
  packing.cells = {{0, 0, {Mat3::Identity(), Vec3(100, 0, 0)}}};
  packing.container = std::make_shared<PeriodicSpace>(Vec3(2.0, 0, 0));
  Certificate certificate = certify(packing.input());
  REQUIRE(certificate.overlapping.size() == 1);  // faces touch
  REQUIRE(certificate.overlapping[0].shift == Vec3(2.0, 0, 0));
  packing.container = std::make_shared<PeriodicSpace>(Vec3(2.25, 0, 0));
  certificate = certify(packing.input());
  REQUIRE(certificate.clean());
  REQUIRE(certificate.minimumGap == 0.25);
  packing.container = std::make_shared<PeriodicSpace>(Vec3(0.7, 0, 0));
  REQUIRE(certify(packing.input()).overlapping.size() == 2);  // images 1 and 2
}

TEST_CASE("A gap smaller than the required one is a violation, an equal one is not", "[certificate]") {
  Packing packing;
  packing.shapes = {std::make_shared<Shape>(sample::box({-1, -1, -1}, {1, 1, 1}), ellipsoidProfile(1, 1, 1))};
  packing.container = std::make_shared<PeriodicSpace>(Vec3(8.0, 0, 0));
  packing.cells = {{0, 0, {Mat3::Identity(), Vec3(0.5, 0, 0)}}, {0, 0, {Mat3::Identity(), Vec3(6.25, 0, 0)}}};
  CertificateInput input = packing.input();  // gaps 3.75 and, through the period, 0.25
  for (double required : {0.0, 0.2, 0.25, 0.26, 3.75, 3.8}) {
    input.requiredGap = required;
    const std::size_t faults = required <= 0.25 ? 0 : required <= 3.75 ? 1 : 2;
    const Certificate certificate = certify(input, 0.1);
    REQUIRE(certificate.overlapping.size() == faults);
    REQUIRE(findOverlaps(input).size() == faults);
    REQUIRE(findOverlaps(input, {1}).size() == faults);
    for (const OverlappingPair& p : certificate.overlapping) {
      REQUIRE(p.gap == (p.shift[0] == 0.0 ? 3.75 : 0.25));
      REQUIRE_FALSE(p.contained);
    }
  }
}

TEST_CASE("findOverlaps examines only pairs with a moved cell, but all of them", "[certificate]") {
  const Vec3 period(8, 7, 9);
  const Packing packing = randomPacking(5, 25, period, 8.0);
  const CertificateInput input = packing.input();
  const auto all = keyed(findOverlaps(input));
  REQUIRE(all == keyed(certify(input).overlapping));
  REQUIRE(all.size() > 10);
  REQUIRE(findOverlaps(input, {}).empty());
  for (const std::vector<std::int64_t>& moved : {std::vector<std::int64_t>{3}, {7, 1, 20}, {24, 0, 0, 12}}) {
    std::map<Key, bool> expected;
    for (const auto& entry : all)
      if (std::count(moved.begin(), moved.end(), std::get<0>(entry.first)) ||
          std::count(moved.begin(), moved.end(), std::get<1>(entry.first)))
        expected.insert(entry);
    REQUIRE(keyed(findOverlaps(input, moved)) == expected);
  }
}

TEST_CASE("Walls are queried only about cells near them, and their violations are reported",
          "[certificate]") {
  for (double slack : {0.0, 0.5}) {
    HalfSpaceWall wall(slack);
    Packing packing;
    packing.shapes = {ball(1.0), ball(1.0)};
    packing.walls = {&wall, nullptr};
    for (double x : {5.0, 1.4, 1.2, 0.5, -0.3, -3.0})
      packing.cells.push_back({0, 0, {Mat3::Identity(), Vec3(x, 10.0 * x, 0)}});
    packing.cells.push_back({1, 1, {Mat3::Identity(), Vec3(-3.0, 50.0, 50.0)}});  // knows no wall
    for (const double interest : {0.1, 0.3, 1.0}) {
      wall.asked = 0;
      const Certificate certificate = certify(packing.input(), interest);
      REQUIRE(certificate.overlapping.empty());
      REQUIRE_FALSE(certificate.clean());
      REQUIRE(certificate.misplaced.size() == 3);
      REQUIRE(certificate.misplaced[0].cell == 3);
      REQUIRE(certificate.misplaced[0].reason == "meets the wall");
      REQUIRE(certificate.misplaced[2].cell == 5);
      REQUIRE(certificate.misplaced[2].reason == "is outside the lumen");
      REQUIRE(certificate.minimumWallGap == 0.0);
      REQUIRE(wall.asked == (interest == 0.1 ? 3 : interest == 0.3 ? 4 : 5));
    }
  }
}

TEST_CASE("A cell closer to its wall than required is misplaced, and the smallest wall gap is reported",
          "[certificate]") {
  HalfSpaceWall wall;
  Packing packing;
  packing.shapes = {std::make_shared<Shape>(sample::box({-1, -1, -1}, {1, 1, 1}), ellipsoidProfile(1, 1, 1)),
                    ball(1.0)};
  packing.walls = {&wall, nullptr};
  for (double x : {3.0, 1.25, 1.5}) packing.cells.push_back({0, 0, {Mat3::Identity(), Vec3(x, 10.0 * x, 0)}});
  packing.cells.push_back({1, 1, {Mat3::Identity(), Vec3(0, -50, 0)}});  // knows no wall
  CertificateInput input = packing.input();
  REQUIRE(certify(input).clean());
  REQUIRE(certify(input).minimumWallGap == 0.25);
  REQUIRE(certify(input, 0.2).minimumWallGap == infinite);
  for (const double interest : {0.001, 0.3, 1.0})
    for (const double required : {0.25, 0.2500001, 0.5, 0.51, 5.0}) {
      input.requiredWallGap = required;
      const Certificate certificate = certify(input, interest);
      REQUIRE(certificate.overlapping.empty());
      REQUIRE(certificate.misplaced.size() == (required == 0.25  ? 0
                                               : required <= 0.5 ? 1
                                               : required < 2.0  ? 2
                                                                 : 3));
      REQUIRE(certificate.minimumWallGap == (interest > 0.25 ? 0.25 : infinite));
      for (const MisplacedCell& m : certificate.misplaced)
        REQUIRE(m.gap == (m.cell == 0 ? 2.0 : m.cell == 1 ? 0.25 : 0.5));
      if (required == 0.51)
        REQUIRE(certificate.misplaced[1].reason == "is 0.5 µm from the wall, less than the required 0.51 µm");
      if (required == 0.2500001)  // both would be 0.25 in six digits
        REQUIRE(certificate.misplaced[0].reason ==
                "is 0.25 µm from the wall, less than the required 0.2500001 µm");
    }
}

TEST_CASE("Counts and volumes are right for scaled cells and for no cells", "[certificate]") {
  Packing packing;
  packing.shapes = {std::make_shared<Shape>(sample::box({-1, -1, -1}, {1, 1, 1}), ellipsoidProfile(1, 1, 1))};
  REQUIRE(certify(packing.input()).clean());
  packing.cells = {{0, 0, {Mat3::Identity(), Vec3::Zero()}},
                   {0, 0, {0.5 * Mat3::Identity(), Vec3(1.75, 0, 0)}}};
  const Certificate certificate = certify(packing.input());
  REQUIRE(certificate.cells == 2);
  REQUIRE(certificate.cellVolume == Approx(9.0));
  REQUIRE(certificate.pairsTested == 1);
  REQUIRE(certificate.minimumGap == 0.25);
  REQUIRE(certify(packing.input(), 0.2).minimumGap == infinite);
}

TEST_CASE("Gaps are measured beyond those that are required", "[certificate]") {
  Physics physics;
  physics.container = std::make_shared<PeriodicSpace>(Vec3::Constant(100.0));
  physics.add("ball", ball(1.0), 2);
  const std::vector<PlacedCell> cells = {{0, 0, {Mat3::Identity(), Vec3(10, 10, 10)}},
                                         {0, 0, {Mat3::Identity(), Vec3(13.6, 10, 10)}}};
  const HalfSpaceWall wall;
  const auto certificate = [&](double clearance, double wallClearance, double extra) {
    physics.clearance = clearance;
    physics.wallClearance = wallClearance;
    physics.species[0].freedom.extraWallClearance = extra;
    CertificateInput input = certificateInputOf(physics, cells);
    input.walls = {&wall};
    return certify(input);
  };
  const Certificate usual = certificate(0.0, 0.0, 0.0);
  CHECK(usual.minimumGap == infinite);
  CHECK(usual.minimumWallGap == infinite);
  CHECK(usual.gapsMeasuredUpTo == usualGapOfInterest);
  const Certificate wide = certificate(1.5, 0.0, 0.0);
  CHECK(wide.clean());
  CHECK(wide.minimumGap == Approx(1.6).margin(1e-3));
  CHECK(wide.gapsMeasuredUpTo == 2.25);
  CHECK(wide.minimumWallGap == infinite);
  for (const double extra : {0.0, 3.0}) {
    const Certificate away = certificate(0.0, 8.0 - extra, extra);
    CHECK(away.clean());
    CHECK(away.minimumWallGap == Approx(9.0).margin(1e-2));
    CHECK(away.wallGapsMeasuredUpTo == 12.0);
    CHECK(away.minimumGap == infinite);
  }
}

TEST_CASE("A stopped certificate is not clean, and cells that cannot be examined are rejected",
          "[certificate]") {
  Packing packing;
  packing.shapes = {ball(1.0)};
  packing.container = std::make_shared<PeriodicSpace>(Vec3(10, 10, 10));
  for (const double x : {1.0, 4.0, 7.0}) packing.cells.push_back({0, 0, {Mat3::Identity(), Vec3(x, 5, 5)}});
  REQUIRE(certify(packing.input()).clean());
  for (const int polls : {0, 1, 2}) {
    CertificateInput input = packing.input();
    int left = polls;
    input.stop = [&] { return left-- == 0; };
    const Certificate stopped = certify(input);
    CHECK_FALSE(stopped.complete);
    CHECK_FALSE(stopped.clean());
  }
  for (const double period : {0.02, 1e-6, 1e-9, 1e-300}) {
    CAPTURE(period);
    packing.container = std::make_shared<PeriodicSpace>(Vec3(10, period, 10));
    CHECK_THROWS_AS(certify(packing.input()), InputError);
  }
  for (const double period : {1.0, 0.2}) {
    CAPTURE(period);
    packing.container = std::make_shared<PeriodicSpace>(Vec3(10, period, 10));
    CHECK_FALSE(certify(packing.input(), 0.1).clean());
  }
}

TEST_CASE("A limited search lists all pairs below its limit, otherwise a few, and walls and gaps completely",
          "[certificate][threads]") {
  const auto one = ball(1.0);
  std::vector<PlacedCell> cells(150);
  const std::size_t clean = GENERATE(0, 20);  // cells that overlap nothing come first
  for (std::size_t i = 0; i < cells.size(); ++i)
    cells[i].placement.translation =
        i < clean ? Vec3(20.0 + 3.0 * double(i), 0.0, 0.0) : Vec3(5.0, 5.0, 5.0 + 0.001 * double(i));
  CertificateInput input;
  input.shapes = {one.get()};
  input.cells = &cells;
  const auto heap = std::int64_t(cells.size() - clean), pairs = heap * (heap - 1) / 2;
  const auto limited = [&](std::int64_t most) {
    input.threads = Threads(4);
    LimitedSearch search{OverlapSearch(std::int64_t(cells.size()), most)};
    input.largestGap = 2.0;
    return Certifier(input, &search).certificate();
  };
  const Certificate whole = limited(pairs + 1);
  CHECK(std::int64_t(whole.overlapping.size()) == pairs);
  CHECK_FALSE(whole.moreOverlaps);
  CHECK(whole.pairsTested == certify(input).pairsTested);

  for (const std::int64_t most : {std::int64_t(100), pairs}) {
    const Certificate some = limited(most);
    CHECK(some.moreOverlaps);
    CHECK(some.complete);
    CHECK_FALSE(some.clean());
    CHECK(some.minimumGap == 0.0);
    CHECK(some.cells == std::int64_t(cells.size()));
    REQUIRE(some.overlapping.size() >= 20);
    CHECK(std::int64_t(some.overlapping.size()) < std::max<std::int64_t>(most, 25));
    CHECK(some.overlapping[0].first == std::int64_t(clean));
    CHECK(some.overlapping[0].second == std::int64_t(clean) + 1);
    // The same pairs whenever threads end.
    const Certificate again = limited(most);
    REQUIRE(again.overlapping.size() == some.overlapping.size());
    for (std::size_t i = 0; i < some.overlapping.size(); ++i) {
      CHECK(again.overlapping[i].first == some.overlapping[i].first);
      CHECK(again.overlapping[i].second == some.overlapping[i].second);
    }
  }
}

TEST_CASE("The smallest gap of a limited search is that of all pairs", "[certificate]") {
  const auto one = ball(1.0);
  std::vector<PlacedCell> cells(50);
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i].placement.translation = Vec3(3.0 * double(i), 0, 0);
  CertificateInput input;
  input.shapes = {one.get()};
  input.cells = &cells;
  input.requiredGap = 1.5;
  const auto limited = [&] {
    LimitedSearch search{OverlapSearch(std::int64_t(cells.size()), 10)};
    input.largestGap = 2.0;
    return Certifier(input, &search).certificate();
  };
  cells.back().placement.translation.x() -= 0.5;  // a pair that is not listed is the nearest
  const Certificate near = limited();
  REQUIRE(near.moreOverlaps);
  CHECK(near.overlapping.back().second < 48);
  CHECK(near.minimumGap == Approx(0.5).margin(0.03));
  cells.back().placement.translation.x() -= 1.0;  // or touches
  CHECK(limited().minimumGap == 0.0);
}
