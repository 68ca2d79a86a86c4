// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/random.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

using Words = std::array<std::uint32_t, 4>;

/// uniform4 as the words it is made of.
Words wordsOf(std::uint64_t seed, std::uint32_t stream, std::uint64_t cell, std::uint32_t iteration) {
  const auto u = uniform4(seed, static_cast<RandomStream>(stream), cell, iteration);
  Words words;
  for (int k = 0; k < 4; ++k) words[k] = std::uint32_t(u[k] * 0x1p32);
  return words;
}

}  // namespace

TEST_CASE("uniform4 reproduces the published test vectors of Philox-4x32-10", "[random]") {
  REQUIRE(wordsOf(0, 0, 0, 0) == Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
  REQUIRE(wordsOf(~0ull, ~0u, ~0ull, ~0u) == Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
  // Counter 243f6a88 85a308d3 13198a2e 03707344, key a4093822 299f31d0
  REQUIRE(wordsOf(0x299f31d0a4093822ull, 0x03707344, 0x85a308d3243f6a88ull, 0x13198a2e) ==
          Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});
}

TEST_CASE("uniform4 is uniform and its numbers are uncorrelated", "[random]") {
  constexpr int cells = 50000;
  double sum[4] = {}, squares[4] = {}, products = 0.0, neighbours = 0.0, streams = 0.0;
  std::array<double, 4> last{};
  for (int cell = 0; cell < cells; ++cell) {
    const auto u = uniform4(7, RandomStream::position, cell, 0);
    const auto other = uniform4(7, RandomStream::orientation, cell, 0);
    for (int k = 0; k < 4; ++k) {
      REQUIRE((u[k] >= 0.0 && u[k] < 1.0));
      sum[k] += u[k];
      squares[k] += (u[k] - 0.5) * (u[k] - 0.5);
    }
    products += (u[0] - 0.5) * (u[1] - 0.5);
    neighbours += (u[0] - 0.5) * (last[0] - 0.5);
    streams += (u[0] - 0.5) * (other[0] - 0.5);
    last = u;
  }
  // Six standard deviations: sqrt(1/12 n) of the mean, sqrt(1/180 n) of the variance, 1/12 sqrt(n) of the
  // rest.
  const double root = 6.0 / std::sqrt(double(cells));
  for (int k = 0; k < 4; ++k) {
    REQUIRE(sum[k] / cells == Approx(0.5).margin(root / std::sqrt(12.0)));
    REQUIRE(squares[k] / cells == Approx(1.0 / 12.0).margin(root / std::sqrt(180.0)));
  }
  for (const double correlation : {products, neighbours, streams})
    REQUIRE(std::abs(correlation) / cells < root / 12.0);
}

TEST_CASE("uniform4 does not depend on earlier draws", "[random]") {
  std::vector<std::array<double, 4>> forwards, backwards;
  for (int i = 0; i < 100; ++i) forwards.push_back(uniform4(3, RandomStream::kick, 10 + i % 10, i / 10));
  for (int i = 99; i >= 0; --i) backwards.push_back(uniform4(3, RandomStream::kick, 10 + i % 10, i / 10));
  for (int i = 0; i < 100; ++i) REQUIRE(forwards[i] == backwards[99 - i]);
  for (int i = 1; i < 100; ++i) REQUIRE(forwards[i] != forwards[0]);
  REQUIRE(uniform4(3, RandomStream::kick, 1, 0) != uniform4(4, RandomStream::kick, 1, 0));
  REQUIRE(uniform4(3, RandomStream::kick, 1, 0) != uniform4(3ull + (1ull << 32), RandomStream::kick, 1, 0));
  REQUIRE(uniform4(3, RandomStream::kick, 1, 0) != uniform4(3, RandomStream::kick, 1 + (1ull << 32), 0));
}

TEST_CASE("Random rotations and directions are uniform", "[random]") {
  constexpr int draws = 50000;
  Vec3 axisMean = Vec3::Zero(), directionMean = Vec3::Zero();
  Mat3 axisMoments = Mat3::Zero(), directionMoments = Mat3::Zero();
  Mat3 squares = Mat3::Zero();
  double angle = 0.0;
  for (int i = 0; i < draws; ++i) {
    const auto u = uniform4(11, RandomStream::orientation, i, 0);
    const Quaternion q = uniformRotation(u[0], u[1], u[2]);
    REQUIRE(q.norm() == Approx(1.0));
    const Mat3 m = q.toRotationMatrix();
    for (int k = 0; k < 3; ++k) squares.col(k) += m.col(k).cwiseProduct(m.col(k));
    const Vec3 axis = m.col(1), direction = uniformDirection(u[2], u[3]);
    REQUIRE(direction.norm() == Approx(1.0));
    axisMean += axis;
    directionMean += direction;
    axisMoments += Mat3::outerProduct(axis, axis);
    directionMoments += Mat3::outerProduct(direction, direction);
    angle += 2.0 * std::acos(std::min(1.0, std::abs(q.w())));
  }
  const double noise = 6.0 / std::sqrt(double(draws));
  REQUIRE((axisMean / draws).norm() < noise);
  REQUIRE((directionMean / draws).norm() < noise);
  REQUIRE((axisMoments / draws - Mat3::Identity() / 3.0).norm() < noise);
  REQUIRE((directionMoments / draws - Mat3::Identity() / 3.0).norm() < noise);
  REQUIRE((squares / draws - Mat3::Constant(1.0 / 3.0)).norm() < noise);
  // The angle of a uniform rotation has density (1 - cos a) / pi: mean pi/2 + 2/pi.
  REQUIRE(angle / draws == Approx(M_PI / 2.0 + 2.0 / M_PI).margin(noise));
}
