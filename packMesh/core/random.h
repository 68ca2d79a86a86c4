// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Random numbers as a pure function of (seed, stream, cell, iteration).
#pragma once

#include <Random123/philox.h>

#include <array>
#include <cmath>
#include <cstdint>

#include "packMesh/core/vector.h"

namespace packmesh {

/// Purposes of random numbers; each has its own stream.
enum class RandomStream : std::uint32_t {
  position = 1,
  orientation = 2,
  kick = 3,
  turn = 4,
  draw = 5,
  sample = 6,
  begin = 7,
  room = 8
};

/// Four independent numbers, uniform in [0, 1), for a seed, stream, global cell id and iteration
/// (Philox-4x32-10: Salmon et al., SC 2011).
inline std::array<double, 4> uniform4(std::uint64_t seed, RandomStream stream, std::uint64_t cell,
                                      std::uint32_t iteration) {
  using Generator = r123::Philox4x32;
  const Generator::ctr_type counter = {{static_cast<std::uint32_t>(cell),
                                        static_cast<std::uint32_t>(cell >> 32), iteration,
                                        static_cast<std::uint32_t>(stream)}};
  const Generator::key_type key = {
      {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  const Generator::ctr_type bits = Generator()(counter, key);
  std::array<double, 4> out;
  for (int k = 0; k < 4; ++k) out[k] = bits[k] * 0x1p-32;
  return out;
}

/// Uniformly distributed rotation from three uniform numbers (Shoemake, Graphics Gems III, 1992).
inline Quaternion uniformRotation(double u, double v, double w) {
  constexpr double twoPi = 6.283185307179586;
  const double a = std::sqrt(1.0 - u), b = std::sqrt(u);
  return Quaternion(b * std::cos(twoPi * w), a * std::sin(twoPi * v), a * std::cos(twoPi * v),
                    b * std::sin(twoPi * w));
}

/// Uniformly distributed direction from two uniform numbers.
inline Vec3 uniformDirection(double u, double v) {
  constexpr double twoPi = 6.283185307179586;
  const double z = 2.0 * u - 1.0, r = std::sqrt(std::max(0.0, 1.0 - z * z));
  return {r * std::cos(twoPi * v), r * std::sin(twoPi * v), z};
}

}  // namespace packmesh
