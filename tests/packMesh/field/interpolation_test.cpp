// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/field/interpolation.h"
#include "packMesh/simd/lanes.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

struct Example {
  double corner[8], t[3];
};

Example randomExample(std::mt19937& random) {
  std::uniform_real_distribution<double> value(-3.0, 3.0), unit(0.0, 1.0);
  Example example;
  for (double& c : example.corner) c = value(random);
  for (double& t : example.t) t = unit(random);
  return example;
}

}  // namespace

TEST_CASE("Lanes are interpolated to the bits of scalars", "[field][kernel]") {
  std::mt19937 random(1);
  for (int n = 0; n < 200; ++n) {
    float c[8][laneCount], t[3][laneCount];
    for (int lane = 0; lane < laneCount; ++lane) {
      const Example example = randomExample(random);
      for (int k = 0; k < 8; ++k) c[k][lane] = float(example.corner[k]);
      for (int k = 0; k < 3; ++k) t[k][lane] = float(example.t[k]);
    }
    Lanes corners[8], part[3];
    for (int k = 0; k < 8; ++k) corners[k] = load(c[k]);
    for (int k = 0; k < 3; ++k) part[k] = load(t[k]);
    const Trilinear<Lanes> found(corners, part);
    for (int lane = 0; lane < laneCount; ++lane) {
      float scalarCorners[8], scalarPart[3];
      for (int k = 0; k < 8; ++k) scalarCorners[k] = c[k][lane];
      for (int k = 0; k < 3; ++k) scalarPart[k] = t[k][lane];
      const Trilinear<float> expected(scalarCorners, scalarPart);
      const float inLanes[4] = {laneOf(found.value, lane), laneOf(found.slope[0], lane),
                                laneOf(found.slope[1], lane), laneOf(found.slope[2], lane)};
      const float scalars[4] = {expected.value, expected.slope[0], expected.slope[1], expected.slope[2]};
      REQUIRE(std::memcmp(inLanes, scalars, sizeof scalars) == 0);
    }
  }
}

TEST_CASE("Trilinear interpolation has the values of the corners", "[field]") {
  std::mt19937 random(3);
  const Example example = randomExample(random);
  for (int c = 0; c < 8; ++c) {
    const double t[3] = {double(c & 1), double(c >> 1 & 1), double(c >> 2)};
    const Trilinear<double> found(example.corner, t);
    REQUIRE(found.value == Approx(example.corner[c]).margin(1e-14));
  }
}

TEST_CASE("Slopes of a trilinear interpolation are its differences", "[field]") {
  std::mt19937 random(4);
  for (int n = 0; n < 200; ++n) {
    const Example example = randomExample(random);
    const Trilinear<double> found(example.corner, example.t);
    for (int k = 0; k < 3; ++k) {  // linear along an axis: any step will do
      const auto valueAt = [&](double t) {
        Example moved = example;
        moved.t[k] = t;
        return Trilinear<double>(moved.corner, moved.t).value;
      };
      REQUIRE(found.slope[k] == Approx(valueAt(1.0) - valueAt(0.0)).margin(1e-13));
      REQUIRE(found.slope[k] == Approx((valueAt(0.6) - valueAt(0.4)) / 0.2).margin(1e-13));
    }
  }
}
