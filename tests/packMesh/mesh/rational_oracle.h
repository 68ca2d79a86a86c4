// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Signs of orientation determinants by GMP, of any finite doubles: rationals whose common denominator
/// is a power of two.
#pragma once

#include <gmpxx.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace packmesh::test {

template <std::size_t N>
using Points = std::array<std::array<double, N - 1>, N>;  ///< N points in N - 1 dimensions

/// The determinant of the differences of all points but the last to the last.
template <std::size_t N>
int exactOrientation(const Points<N>& points) {
  int least = std::numeric_limits<int>::max();
  for (const auto& point : points)
    for (const double x : point) {
      int exponent;
      if (std::frexp(x, &exponent) != 0.0) least = std::min(least, exponent);
    }
  std::array<std::array<mpz_class, N - 1>, N> numerator;
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t k = 0; k + 1 < N; ++k) {
      int exponent;
      const double mantissa = std::frexp(points[i][k], &exponent);
      if (mantissa == 0.0) continue;
      numerator[i][k] = std::ldexp(mantissa, 53);
      numerator[i][k] <<= unsigned(exponent - least);
    }
  for (std::size_t i = 0; i + 1 < N; ++i)
    for (std::size_t k = 0; k + 1 < N; ++k) numerator[i][k] -= numerator[N - 1][k];
  const auto& d = numerator;
  if constexpr (N == 3) {
    return sgn(mpz_class(d[0][0] * d[1][1] - d[0][1] * d[1][0]));
  } else {
    const mpz_class x = d[1][1] * d[2][2] - d[1][2] * d[2][1], y = d[1][2] * d[2][0] - d[1][0] * d[2][2],
                    z = d[1][0] * d[2][1] - d[1][1] * d[2][0];
    return sgn(mpz_class(d[0][0] * x + d[0][1] * y + d[0][2] * z));
  }
}

}  // namespace packmesh::test
