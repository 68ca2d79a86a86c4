// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Sixteen floats that are worked on together, as many vector registers of the instruction set at hand
/// as that takes. Every operation is one IEEE operation per lane, so that all instruction sets give the same
/// bits.
///
/// For the contact kernel's translation units only: everything has internal linkage, because each of them is
/// compiled for another processor.
#pragma once

#include <immintrin.h>

namespace packmesh {
namespace {

constexpr int laneCount = 16;
#if defined(__AVX512F__)
constexpr int registerLanes = 16;
#elif defined(__AVX2__)
constexpr int registerLanes = 8;
#else
constexpr int registerLanes = 4;
#endif
constexpr int registers = laneCount / registerLanes;

typedef float Register __attribute__((vector_size(registerLanes * sizeof(float))));
typedef float UnalignedRegister
    __attribute__((vector_size(registerLanes * sizeof(float)), may_alias, aligned(4)));
typedef int MaskRegister __attribute__((vector_size(registerLanes * sizeof(int))));

struct Mask {
  MaskRegister r[registers];
};

struct Lanes {
  Register r[registers];
};

template <class Operation>
inline __attribute__((always_inline)) Lanes each(Operation operation) {
  Lanes out;
  for (int k = 0; k < registers; ++k) out.r[k] = operation(k);
  return out;
}
template <class Operation>
inline __attribute__((always_inline)) Mask eachMask(Operation operation) {
  Mask out;
  for (int k = 0; k < registers; ++k) out.r[k] = operation(k);
  return out;
}

inline Lanes splat(float v) {
  return each([&](int) { return Register{} + v; });
}
inline Lanes load(const float* p) {
  return each(
      [&](int k) -> Register { return *reinterpret_cast<const UnalignedRegister*>(p + k * registerLanes); });
}
inline Lanes operator+(const Lanes& a, const Lanes& b) {
  return each([&](int k) { return a.r[k] + b.r[k]; });
}
inline Lanes operator-(const Lanes& a, const Lanes& b) {
  return each([&](int k) { return a.r[k] - b.r[k]; });
}
inline Lanes operator*(const Lanes& a, const Lanes& b) {
  return each([&](int k) { return a.r[k] * b.r[k]; });
}
inline Lanes operator/(const Lanes& a, const Lanes& b) {
  return each([&](int k) { return a.r[k] / b.r[k]; });
}
inline Lanes operator+(const Lanes& a, float b) {
  return a + splat(b);
}
inline Lanes operator-(const Lanes& a, float b) {
  return a - splat(b);
}
inline Lanes operator+(float a, const Lanes& b) {
  return splat(a) + b;
}
inline Lanes operator-(float a, const Lanes& b) {
  return splat(a) - b;
}
inline Lanes operator*(float a, const Lanes& b) {
  return splat(a) * b;
}
inline Lanes operator*(const Lanes& a, float b) {
  return a * splat(b);
}
inline Lanes& operator+=(Lanes& a, const Lanes& b) {
  return a = a + b;
}

inline Mask operator<(const Lanes& a, const Lanes& b) {
  return eachMask([&](int k) { return a.r[k] < b.r[k]; });
}
inline Mask operator&(const Mask& a, const Mask& b) {
  return eachMask([&](int k) { return a.r[k] & b.r[k]; });
}
inline Mask operator|(const Mask& a, const Mask& b) {
  return eachMask([&](int k) { return a.r[k] | b.r[k]; });
}
inline Lanes select(const Mask& m, const Lanes& a, const Lanes& b) {
  return each([&](int k) { return m.r[k] ? a.r[k] : b.r[k]; });
}
inline Lanes larger(const Lanes& a, const Lanes& b) {
  return each([&](int k) { return a.r[k] > b.r[k] ? a.r[k] : b.r[k]; });
}
inline Lanes smaller(const Lanes& a, const Lanes& b) {
  return each([&](int k) { return a.r[k] < b.r[k] ? a.r[k] : b.r[k]; });
}
inline Lanes magnitude(const Lanes& a) {
  return each(
      [&](int k) { return reinterpret_cast<Register>(reinterpret_cast<MaskRegister>(a.r[k]) & 0x7fffffff); });
}
inline Lanes squareRoot(const Lanes& a) {
  return each([&](int k) {
#if defined(__AVX512F__)
    return static_cast<Register>(_mm512_sqrt_ps(static_cast<__m512>(a.r[k])));
#elif defined(__AVX2__)
    return static_cast<Register>(_mm256_sqrt_ps(static_cast<__m256>(a.r[k])));
#else
    return static_cast<Register>(_mm_sqrt_ps(static_cast<__m128>(a.r[k])));
#endif
  });
}

/// Bit k is set where lane k of the mask is.
inline unsigned bitsOf(const Mask& m) {
  unsigned bits = 0;
  for (int k = 0; k < registers; ++k) {
#if defined(__AVX512F__)
    bits |= _mm512_test_epi32_mask(reinterpret_cast<__m512i>(m.r[k]), reinterpret_cast<__m512i>(m.r[k]));
#elif defined(__AVX2__)
    bits |= static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(m.r[k]))) << k * registerLanes;
#else
    bits |= static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(m.r[k]))) << k * registerLanes;
#endif
  }
  return bits;
}

/// Lane k is p[k / 4].
inline Lanes loadEachFourTimes(const float* p) {
#if defined(__AVX512F__)
  const __m512i from = _mm512_set_epi32(3, 3, 3, 3, 2, 2, 2, 2, 1, 1, 1, 1, 0, 0, 0, 0);
  const __m512 four = _mm512_castps128_ps512(_mm_loadu_ps(p));
  return {{static_cast<Register>(_mm512_permutexvar_ps(from, four))}};
#elif defined(__AVX2__)
  const __m256 four = _mm256_castps128_ps256(_mm_loadu_ps(p));
  return {{static_cast<Register>(_mm256_permutevar8x32_ps(four, _mm256_set_epi32(1, 1, 1, 1, 0, 0, 0, 0))),
           static_cast<Register>(_mm256_permutevar8x32_ps(four, _mm256_set_epi32(3, 3, 3, 3, 2, 2, 2, 2)))}};
#else
  return each([&](int k) { return Register{} + p[k]; });
#endif
}

/// Lane k is p[k % 4].
inline Lanes loadAllFourTimes(const float* p) {
#if defined(__AVX512F__)
  return {{static_cast<Register>(_mm512_broadcast_f32x4(_mm_loadu_ps(p)))}};
#elif defined(__AVX2__)
  const Register four = static_cast<Register>(_mm256_broadcast_ps(reinterpret_cast<const __m128*>(p)));
  return {{four, four}};
#else
  return each([&](int) -> Register { return *reinterpret_cast<const UnalignedRegister*>(p); });
#endif
}

inline void store(const Lanes& a, float* out) {
  for (int k = 0; k < registers; ++k) *reinterpret_cast<UnalignedRegister*>(out + k * registerLanes) = a.r[k];
}

/// Sum in an order that every instruction set keeps: lanes k and k + 8, then k and k + 4, ...
inline float sum(const Lanes& a) {
  float v[laneCount];
  store(a, v);
  for (int half = laneCount / 2; half > 0; half /= 2)
    for (int k = 0; k < half; ++k) v[k] = v[k] + v[k + half];
  return v[0];
}
inline float largest(const Lanes& a) {
  float v[laneCount];
  store(a, v);
  for (int half = laneCount / 2; half > 0; half /= 2)
    for (int k = 0; k < half; ++k) v[k] = v[k] > v[k + half] ? v[k] : v[k + half];
  return v[0];
}
inline float smallest(const Lanes& a) {
  return -largest(splat(0.0f) - a);
}

}  // namespace
}  // namespace packmesh
