// SPDX-License-Identifier: AGPL-3.0-or-later
// The certificate does not know where a packing is, how it is turned, how large it is or how its cells are
// numbered; and it tells pairs apart that are 1e-12 µm apart.

#include "packMesh/certificate/certificate.h"
#include "packMesh/certificate/certifier.h"
#include "packMesh/container/primitives.h"
#include "tests/support/catch.h"
#include "tests/support/shapes.h"

using namespace packmesh;

namespace {

using SymmetricPairs = std::set<std::pair<std::int64_t, std::int64_t>>;

std::vector<test::ShapePointer> someShapes() {
  static const auto platelet = test::hemocellShape("PLT"),
                    lopsided = std::make_shared<const Shape>(test::convexMesh(3));
  return {test::redCellShape(), platelet, lopsided};
}

/// Red cells, platelets and a lopsided body in a box, some of which meet.
struct SymmetricCrowd {
  std::vector<test::ShapePointer> shapes = someShapes();
  std::vector<PlacedCell> cells;
  Vec3 size = Vec3(21.0, 24.0, 27.0);
  std::array<bool, 3> periodic = {true, true, true};

  explicit SymmetricCrowd(unsigned seed, int count = 40) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(0.0, 1.0);
    for (int i = 0; i < count; ++i) {
      const Mat3 turn = test::randomRotation(random);
      const Vec3 at(part(random), part(random), part(random));
      cells.push_back({i % 3, i % 3, {turn, size.cwiseProduct(at)}});
    }
  }

  /// @param largestGap gaps above this are not measured [µm]
  Certificate certificate(double largestGap = 1.0) const {
    const auto container = makeBox(Box{Vec3::Zero(), size}, periodic);
    CertificateInput input;
    for (const auto& shape : shapes) input.shapes.push_back(shape.get());
    input.walls.assign(shapes.size(), container->wall());
    input.container = container.get();
    input.cells = &cells;
    return certify(input, largestGap);
  }

  /// Without the cells that meet others.
  SymmetricCrowd apart() const {
    SymmetricCrowd kept = *this;
    std::set<std::int64_t> out;
    for (const OverlappingPair& pair : certificate().overlapping)
      if (!out.count(pair.first)) out.insert(pair.second);
    kept.cells.clear();
    for (std::size_t i = 0; i < cells.size(); ++i)
      if (!out.count(std::int64_t(i))) kept.cells.push_back(cells[i]);
    return kept;
  }
};

SymmetricPairs pairsOf(const Certificate& certificate) {
  SymmetricPairs pairs;
  for (const OverlappingPair& pair : certificate.overlapping)
    pairs.insert(std::minmax(pair.first, pair.second));
  return pairs;
}

/// Signed permutations of the axes: the 24 rotations of a cube and their mirror images.
std::vector<Mat3> cubeSymmetries() {
  std::vector<Mat3> all;
  std::array<int, 3> order = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Mat3 map = Mat3::Zero();
      for (int k = 0; k < 3; ++k) map(k, order[k]) = (signs >> k & 1) ? -1.0 : 1.0;
      all.push_back(map);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return all;
}

/// A packing turned or mirrored about the box's middle.
SymmetricCrowd mapped(const SymmetricCrowd& crowd, const Mat3& map) {
  SymmetricCrowd out = crowd;
  out.size = (map * crowd.size).cwiseAbs();
  const Vec3 corner = (map * crowd.size).cwiseMin(0.0);
  for (PlacedCell& cell : out.cells)
    cell.placement = {map * cell.placement.linear, map * cell.placement.translation - corner};
  return out;
}

}  // namespace

TEST_CASE("Certificates of permuted cells contain the same pairs", "[certificate]") {
  for (unsigned seed = 0; seed < 6; ++seed) {
    const SymmetricCrowd crowd(seed);
    const Certificate before = crowd.certificate();
    REQUIRE_FALSE(before.clean());
    std::vector<std::int64_t> order(crowd.cells.size());
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), std::mt19937(seed));
    SymmetricCrowd shuffled = crowd;
    for (std::size_t i = 0; i < order.size(); ++i) shuffled.cells[i] = crowd.cells[order[i]];
    SymmetricPairs renamed;
    for (const auto& [first, second] : pairsOf(shuffled.certificate()))
      renamed.insert(std::minmax(order[first], order[second]));
    CHECK(renamed == pairsOf(before));

    const SymmetricCrowd apart = crowd.apart();
    SymmetricCrowd backwards = apart;
    std::reverse(backwards.cells.begin(), backwards.cells.end());
    REQUIRE(apart.certificate().clean());
    CHECK(backwards.certificate().minimumGap == Approx(apart.certificate().minimumGap).epsilon(1e-12));
    CHECK(backwards.certificate().cellVolume == Approx(apart.certificate().cellVolume).epsilon(1e-12));
  }
}

TEST_CASE("Certificates of rotated and mirrored packings contain the same pairs", "[certificate]") {
  const std::vector<Mat3> maps = cubeSymmetries();
  REQUIRE(maps.size() == 48);
  for (const bool walls : {false, true}) {
    SymmetricCrowd crowd(walls ? 11 : 10);
    if (walls) crowd.periodic = {true, false, true};
    const SymmetricCrowd apart = crowd.apart();
    const Certificate before = crowd.certificate(), clean = apart.certificate();
    REQUIRE_FALSE(before.overlapping.empty());
    REQUIRE(before.misplaced.empty() != walls);
    for (const Mat3& map : maps) {
      const auto periodicOf = [&](SymmetricCrowd one) {
        for (int k = 0; k < 3; ++k)
          for (int from = 0; from < 3; ++from)
            if (map(k, from) != 0.0) one.periodic[k] = crowd.periodic[from];
        return one;
      };
      const Certificate after = periodicOf(mapped(crowd, map)).certificate();
      REQUIRE(pairsOf(after) == pairsOf(before));
      REQUIRE(after.misplaced.size() == before.misplaced.size());
      for (std::size_t i = 0; i < after.misplaced.size(); ++i) {
        CHECK(after.misplaced[i].cell == before.misplaced[i].cell);
        CHECK(after.misplaced[i].reason == before.misplaced[i].reason);
      }
      const Certificate cleanAfter = periodicOf(mapped(apart, map)).certificate();
      CHECK(cleanAfter.minimumGap == Approx(clean.minimumGap).epsilon(1e-9));
      if (clean.misplaced.empty())
        CHECK(cleanAfter.minimumWallGap == Approx(clean.minimumWallGap).epsilon(1e-9));
      CHECK(cleanAfter.cellVolume == Approx(clean.cellVolume).epsilon(1e-12));
    }
  }
}

TEST_CASE("Certificates of translated and arbitrarily rotated packings contain the same pairs",
          "[certificate]") {
  std::mt19937 random(5);
  for (unsigned seed = 20; seed < 26; ++seed) {
    // Shifted in a periodic box, and by whole periods.
    const SymmetricCrowd crowd(seed);
    std::uniform_real_distribution<double> part(0.0, 1.0);
    std::uniform_int_distribution<int> periods(-2, 2);
    const Vec3 shift(part(random), part(random), part(random));
    SymmetricCrowd moved = crowd;
    for (PlacedCell& cell : moved.cells)
      cell.placement.translation +=
          crowd.size.cwiseProduct(shift + Vec3(periods(random), periods(random), periods(random)));
    CHECK(pairsOf(moved.certificate()) == pairsOf(crowd.certificate()));

    // Turned by any angle, where there is no period.
    SymmetricCrowd free = crowd;
    free.size *= 10.0;
    for (PlacedCell& cell : free.cells) cell.placement.translation += 4.0 * crowd.size;
    const Mat3 turn = test::randomRotation(random);
    SymmetricCrowd turned = free;
    for (PlacedCell& cell : turned.cells) {
      const Vec3 middle = 0.5 * free.size;
      cell.placement = {turn * cell.placement.linear, turn * (cell.placement.translation - middle) + middle};
    }
    CHECK(pairsOf(turned.certificate()) == pairsOf(free.certificate()));
    CHECK(turned.apart().certificate().minimumGap ==
          Approx(free.apart().certificate().minimumGap).epsilon(1e-9));
  }
}

TEST_CASE("Certificates scale with the packing, to the bit for powers of two", "[certificate]") {
  for (unsigned seed = 30; seed < 33; ++seed) {
    const SymmetricCrowd crowd(seed), apart = crowd.apart();
    const SymmetricPairs pairs = pairsOf(crowd.certificate());
    const double gap = apart.certificate().minimumGap;
    REQUIRE(gap < 1.0);
    for (const double scale : {0x1p-20, 0.125, 0.5, 2.0, 64.0, 0x1p20, 0.1, 3.7, 1e3}) {
      const auto scaled = [&](SymmetricCrowd one) {
        one.size *= scale;
        for (PlacedCell& cell : one.cells) {
          cell.placement.linear *= scale;
          cell.placement.translation *= scale;
        }
        return one;
      };
      CAPTURE(seed, scale);
      CHECK(pairsOf(scaled(crowd).certificate(scale)) == pairs);
      const double now = scaled(apart).certificate(scale).minimumGap;
      int exponent = 0;
      if (std::frexp(scale, &exponent) == 0.5)
        CHECK(now == scale * gap);
      else
        CHECK(now == Approx(scale * gap).epsilon(1e-9));
    }
  }
}

TEST_CASE("Cells whose faces are 1e-12 µm apart do not overlap, but touching ones do", "[certificate]") {
  const auto cube = std::make_shared<const Shape>(sample::box({-1, -1, -1}, {1, 1, 1}));
  for (const double gap : {1e-12, 3e-11, 1e-9, 1e-6, 1e-3, 0.0, -1e-12, -1e-6})
    for (const int where : {0, 1, 2}) {  // neighbours; images across a period; a wall
      CAPTURE(gap, where);
      SymmetricCrowd two(0, 0);
      two.shapes = {cube};
      two.size = Vec3(16.0, 8.0, 8.0);
      two.periodic = {where < 2, true, true};
      two.cells = {{0, 0, {Mat3::Identity(), Vec3(1.5, 4.0, 4.0)}}};
      double exact = gap;
      if (where == 0) {
        const double x = 1.5 + 2.0 + gap;
        exact = (x - 1.0) - 2.5;  // what rounding has made of it
        two.cells.push_back({0, 0, {Mat3::Identity(), Vec3(x, 4.3, 3.9)}});
      } else if (where == 1) {
        const double x = 15.5 - gap;
        exact = 16.5 - (x + 1.0);
        two.cells.push_back({0, 0, {Mat3::Identity(), Vec3(x, 4.3, 3.9)}});
      } else {
        two.cells[0].placement.translation.x() = 1.0 + gap;
        exact = (1.0 + gap) - 1.0;
      }
      const Certificate certificate = two.certificate();
      CHECK(certificate.clean() == (exact > 0.0));
      const double found = where == 2 ? certificate.minimumWallGap : certificate.minimumGap;
      CHECK(found == Approx(std::max(0.0, exact)).margin(8e-15));
    }
}

TEST_CASE("Red cells at any angle that are 1e-12 µm apart are distinguished from touching ones",
          "[certificate]") {
  std::mt19937 random(9);
  for (int i = 0; i < 25; ++i) {
    SymmetricCrowd two(0, 0);
    two.size = Vec3::Constant(60.0);
    const Vec3 at(20.0, 30.0, 30.0), direction = test::randomDirection(random);
    two.cells = {{0, 0, {test::randomRotation(random), at}}, {0, 0, {test::randomRotation(random), at}}};
    const auto clean = [&](double distance) {
      two.cells[1].placement.translation = at + distance * direction;
      return two.certificate().clean();
    };
    double touching = 0.1, apart = 9.0;
    REQUIRE(clean(apart));
    while (apart - touching > 1e-12) {
      const double middle = 0.5 * (touching + apart);
      (clean(middle) ? apart : touching) = middle;
    }
    // The gap grows with the distance, by no more than it and by no less than a hundredth of it.
    for (const double beyond : {0.0, 1e-12, 1e-11, 1e-9, 1e-6, 1e-3}) {
      CAPTURE(i, beyond);
      REQUIRE(clean(apart + beyond));
      const double gap = two.certificate().minimumGap;
      CHECK(gap > 0.0);
      CHECK(gap <= beyond + 1e-12 + 2e-14);
      if (beyond > 0.0) CHECK_FALSE(clean(touching - beyond));
    }
  }
}
