// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/predicates.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>

// Loops over words are unrolled: most integers have one or two. (At -O3, g++ 12 does not do it on its own.)

namespace packmesh::predicates {
namespace {

__extension__ using Wide = unsigned __int128;

/// An integer of 64 N bits in two's complement, least significant word first.
template <int N>
struct Integer {
  std::uint64_t word[N] = {};

  bool isNegative() const { return word[N - 1] >> 63 != 0; }
  int sign() const {
    if (isNegative()) return -1;
    for (const std::uint64_t w : word)
      if (w != 0) return 1;
    return 0;
  }
};

/// word[0...count) -= other[0...count).
inline void subtract(std::uint64_t* word, const std::uint64_t* other, int count) {
  std::uint64_t borrow = 0;
#pragma GCC unroll 4
  for (int i = 0; i < count; ++i) {
    const Wide difference = Wide{word[i]} - other[i] - borrow;
    word[i] = static_cast<std::uint64_t>(difference);
    borrow = static_cast<std::uint64_t>(difference >> 64) & 1u;
  }
}

template <int N>
Integer<N> operator-(Integer<N> a, const Integer<N>& b) {
  subtract(a.word, b.word, N);
  return a;
}

template <int N>
Integer<N> operator+(Integer<N> a, const Integer<N>& b) {
  std::uint64_t carry = 0;
#pragma GCC unroll 4
  for (int i = 0; i < N; ++i) {
    const Wide sum = Wide{a.word[i]} + b.word[i] + carry;
    a.word[i] = static_cast<std::uint64_t>(sum);
    carry = static_cast<std::uint64_t>(sum >> 64);
  }
  return a;
}

template <int N, int M>
Integer<N + M> operator*(const Integer<N>& a, const Integer<M>& b) {
  Integer<N + M> out;
#pragma GCC unroll 4
  for (int i = 0; i < N; ++i) {
    std::uint64_t carry = 0;
#pragma GCC unroll 4
    for (int j = 0; j < M; ++j) {
      const Wide sum = Wide{a.word[i]} * b.word[j] + out.word[i + j] + carry;
      out.word[i + j] = static_cast<std::uint64_t>(sum);
      carry = static_cast<std::uint64_t>(sum >> 64);
    }
    out.word[i + M] = carry;
  }
  // The words of a negative number are those of the number plus 2^(64 N).
  if (a.isNegative()) subtract(out.word + N, b.word, M);
  if (b.isNegative()) subtract(out.word + M, a.word, N);
  return out;
}

/// mantissa * 2^exponent, the mantissa odd or zero.
struct Scaled {
  std::uint64_t mantissa = 0;
  int exponent = 0;
  bool negative = false;

  explicit Scaled(double x) {
    std::uint64_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    negative = bits >> 63 != 0;
    const int biased = static_cast<int>(bits >> 52 & 0x7ffu);
    mantissa = bits & ((std::uint64_t{1} << 52) - 1);
    if (biased > 0) mantissa |= std::uint64_t{1} << 52;
    if (mantissa == 0) return;
    const int zeros = __builtin_ctzll(mantissa);
    mantissa >>= zeros;
    exponent = std::max(biased, 1) - 1075 + zeros;
  }
  int length() const { return 64 - __builtin_clzll(mantissa); }  ///< [bits]; pre: not zero

  /// As a multiple of 2^unit. Pre: it is one, and the integer has room for it.
  template <int N>
  Integer<N> in(int unit) const {
    Integer<N> out;
    if (mantissa == 0) return out;
    const int shift = exponent - unit, at = shift / 64, by = shift % 64;
    out.word[at] = mantissa << by;
    if (by != 0 && at + 1 < N) out.word[at + 1] = mantissa >> (64 - by);
    return negative ? Integer<N>() - out : out;
  }
};

/// Rows of a determinant's coordinates, the last to be subtracted from the others.
template <int Dimension>
struct Rows {
  std::array<std::array<Scaled, Dimension>, Dimension + 1> at;
  int unit = std::numeric_limits<int>::max();  ///< all are multiples of 2^unit
  int bits = 0;                                ///< ... and less than 2^bits times as large

  void measure() {
    int end = std::numeric_limits<int>::min();
    for (const auto& row : at)
      for (const Scaled& x : row) {
        if (x.mantissa == 0) continue;
        unit = std::min(unit, x.exponent);
        end = std::max(end, x.exponent + x.length());
      }
    bits = end > unit ? end - unit : 0;
  }

  template <int N>
  void differences(Integer<N> (&out)[Dimension][Dimension]) const {
    for (int k = 0; k < Dimension; ++k) {
      const Integer<N> last = at[Dimension][k].template in<N>(unit);
      for (int row = 0; row < Dimension; ++row) out[row][k] = at[row][k].template in<N>(unit) - last;
    }
  }
};

/// Coordinates of B bits have differences of B + 1 bits, products of two of 2B + 2 and differences of these
/// of 2B + 3; products of three of 3B + 4, and the determinant, 6 of them, fewer than 3B + 7; a bit for the
/// sign.
constexpr int mostBits(int words) {
  return 64 * words - 3;
}

template <int N>
int signOf(const Rows<3>& rows) {
  Integer<N> d[3][3];
  rows.differences(d);
  const auto minor = [&](int i, int j) { return d[i][0] * d[j][1] - d[j][0] * d[i][1]; };
  return (d[0][2] * minor(1, 2) + d[1][2] * minor(2, 0) + d[2][2] * minor(0, 1)).sign();
}

template <int N>
int signOf(const Rows<2>& rows) {
  Integer<N> d[2][2];
  rows.differences(d);
  return (d[0][0] * d[1][1] - d[0][1] * d[1][0]).sign();
}

/// Coordinates of a mesh have few bits in common units: 53, and as many as their magnitudes differ by. The
/// longest integers have room for all doubles, 2^-1074 to 2^1024.
template <int Dimension>
int signOfDeterminant(Rows<Dimension>&& rows) {
  rows.measure();
  if (rows.bits <= mostBits(1)) return signOf<1>(rows);
  if (rows.bits <= mostBits(2)) return signOf<2>(rows);
  if (rows.bits <= mostBits(4)) return signOf<4>(rows);
  static_assert(mostBits(33) >= 1074 + 1025);
  return signOf<33>(rows);
}

}  // namespace

int exactSideOfPlane(const double* a, const double* b, const double* c, const double* p) {
  // Frequent in meshes: a plane across an axis, and a corner of the triangle.
  for (int k = 0; k < 3; ++k)
    if (a[k] == p[k] && b[k] == p[k] && c[k] == p[k]) return 0;
  for (const double* corner : {a, b, c})
    if (corner[0] == p[0] && corner[1] == p[1] && corner[2] == p[2]) return 0;
  const auto row = [](const double* x) { return std::array{Scaled(x[0]), Scaled(x[1]), Scaled(x[2])}; };
  return -signOfDeterminant(Rows<3>{{row(a), row(b), row(c), row(p)}});
}

int exactTurn(const double* a, const double* b, const double* p) {
  for (int k = 0; k < 2; ++k)
    if (a[k] == p[k] && b[k] == p[k]) return 0;
  for (const double* end : {a, b})
    if (end[0] == p[0] && end[1] == p[1]) return 0;
  const auto row = [](const double* x) { return std::array{Scaled(x[0]), Scaled(x[1])}; };
  return signOfDeterminant(Rows<2>{{row(a), row(b), row(p)}});
}

}  // namespace packmesh::predicates
