// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/region.h"
#include "packMesh/container/primitives.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

const Box cube{Vec3::Zero(), Vec3::Constant(20.0)};

std::shared_ptr<const Container> box(const Vec3& lo, const Vec3& hi) {
  return makeBox({lo, hi}, {false, false, false});
}

}  // namespace

TEST_CASE("A region is inside one body and outside earlier ones") {
  const std::shared_ptr<const Container> ball = makeSphere(Vec3(10, 10, 10), 5.0);
  const auto inside = std::make_shared<BodyRegion>(ball, cube, Vec3::Zero());
  const auto larger = std::make_shared<BodyRegion>(makeSphere(Vec3(10, 10, 10), 8.0), cube, Vec3::Zero());
  const BodyRegion& inner = *inside;
  const RegionDifference shell(larger, {inside}, cube);
  const RegionDifference rest(nullptr, {inside, larger}, cube);
  for (double r = 0.25; r < 9.5; r += 0.5) {
    const Vec3 p = Vec3(10, 10, 10) + r * Vec3(2, 1, 2) / 3.0;
    CAPTURE(r);
    CHECK(inner.distance(p).distance == Approx(5.0 - r));
    CHECK(shell.distance(p).distance == Approx(std::min(8.0 - r, r - 5.0)));
    CHECK(rest.distance(p).distance == Approx(r - 8.0));
    // Each point belongs to one of them, and gradients lead inwards.
    CHECK(inner.contains(p) + shell.contains(p) + rest.contains(p) == 1);
    CHECK(inner.distance(p).gradient.dot(p - Vec3(10, 10, 10)) < 0.0);
    CHECK(rest.distance(p).gradient.dot(p - Vec3(10, 10, 10)) > 0.0);
  }
}

TEST_CASE("Bodies of a region repeat along periodic axes") {
  const BodyRegion region(makeSphere(Vec3(0, 10, 10), 5.0), cube, Vec3(20, 0, 0));
  CHECK(region.distance(Vec3(19, 10, 10)).distance == Approx(4.0));
  CHECK(region.distance(Vec3(20.5, 10, 10)).distance == Approx(4.5));
  CHECK(region.bounds().size().x() == Approx(20.0));
  const BodyRegion once(makeSphere(Vec3(0, 10, 10), 5.0), cube, Vec3::Zero());
  CHECK(once.distance(Vec3(19, 10, 10)).distance == Approx(-14.0));
  CHECK(once.bounds().hi.x() == Approx(5.0));
}

TEST_CASE("The volume of a region in a lumen is accurate") {
  const auto lumen = makeCylinder(Vec3(10, 10, 10), 0, 8.0, 20.0, false);
  const double pi = std::acos(-1.0);
  const auto share = [&](std::shared_ptr<const Container> body) {
    return volumeInLumen(BodyRegion(std::move(body), lumen->bounds(), lumen->period()), *lumen) /
           lumen->volume();
  };
  CHECK(share(makeSphere(Vec3(10, 10, 10), 5.0)) ==
        Approx(4.0 / 3.0 * pi * 125.0 / lumen->volume()).epsilon(1e-3));
  CHECK(share(box(Vec3(-1, 0, 0), Vec3(4.321, 20, 20))) == Approx(4.321 / 20.0).epsilon(1e-4));
  CHECK(share(box(Vec3(3, -5, -5), Vec3(5, 25, 10))) == Approx(0.05).epsilon(1e-3));
  CHECK(share(box(Vec3(30, 0, 0), Vec3(40, 20, 20))) == 0.0);
  CHECK(volumeInLumen(RegionDifference(nullptr, {}, lumen->bounds()), *lumen) ==
        Approx(lumen->volume()).epsilon(1e-4));
  const auto core = std::make_shared<BodyRegion>(makeCylinder(Vec3(10, 10, 10), 0, 4.0, 20.0, false),
                                                 lumen->bounds(), lumen->period());
  const RegionDifference rest(nullptr, {core}, lumen->bounds());
  CHECK(volumeInLumen(rest, *lumen) == Approx(0.75 * lumen->volume()).epsilon(1e-3));
}

TEST_CASE("A half-space is all of the lumen beyond its plane") {
  const Vec3 normal = Vec3(1, 2, 2) / 3.0;
  const HalfSpace region(Vec3(10, 10, 10), normal, cube, Vec3::Zero());
  for (const double depth : {-3.0, -0.5, 0.0, 2.0}) {
    const WallDistance d = region.distance(Vec3(10, 10, 10) + depth * normal + 4.0 * Vec3(0, 1, -1));
    CHECK(d.distance == Approx(depth).margin(1e-12));
    CHECK((d.gradient - normal).norm() < 1e-12);
  }
  CHECK(region.bounds().hi == cube.hi);
  CHECK(region.bounds().lo == Vec3::Zero());
  const HalfSpace low(Vec3(0, 0, 4), Vec3(0, 0, -1), cube, Vec3::Zero());
  CHECK(low.bounds().hi == Vec3(20, 20, 4));
  const auto lumen = makeBox(cube, {false, false, false});
  CHECK(volumeInLumen(region, *lumen) == Approx(4000.0).epsilon(1e-3));
  CHECK(volumeInLumen(low, *lumen) == Approx(1600.0).epsilon(1e-3));
}

TEST_CASE("Along a periodic axis a half-space ends with the period") {
  const HalfSpace region(Vec3(12, 0, 0), Vec3(1, 0, 0), cube, Vec3(20, 20, 0));
  for (const double image : {0.0, 20.0}) {
    CHECK(region.distance(Vec3(13 + image, 3, 3)).distance == Approx(1.0));
    CHECK(region.distance(Vec3(19 + image, 3, 3)).distance == Approx(1.0));
    CHECK(region.distance(Vec3(11 + image, 3, 3)).distance == Approx(-1.0));
    const WallDistance behind = region.distance(Vec3(1 + image, 3, 3));
    CHECK(behind.distance == Approx(-1.0));
    CHECK(behind.gradient == Vec3(-1, 0, 0));
  }
  CHECK(region.distance(Vec3(16, 0, 0)).distance == Approx(4.0));  // no end along y
}
