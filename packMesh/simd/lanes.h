// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Sixteen floats that are worked on together, as many vector registers of the instruction set at hand
/// as that takes. Every operation is one IEEE operation per lane, so that all instruction sets give the same
/// bits.
///
/// For the kernels' translation units only: everything has internal linkage, because each of them is compiled
/// for another processor.
#pragma once

#include <immintrin.h>

namespace packmesh {
namespace {

constexpr int laneCount = 16;

/// One register of the instruction set, and the operations that the vector extensions of the compiler do not
/// know or make several instructions of.
#if defined(__AVX512F__)
constexpr int registerLanes = 16;
typedef __m512 Native;
inline Native nativeSplat(float v) {
  return _mm512_set1_ps(v);
}
inline Native nativeLarger(Native a, Native b) {
  return _mm512_max_ps(a, b);
}
inline Native nativeSmaller(Native a, Native b) {
  return _mm512_min_ps(a, b);
}
inline Native nativeRoot(Native a) {
  return _mm512_sqrt_ps(a);
}
inline unsigned nativeBits(Native a, Native b) {
  return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
}
#elif defined(__AVX__)
constexpr int registerLanes = 8;
typedef __m256 Native;
inline Native nativeSplat(float v) {
  return _mm256_set1_ps(v);
}
inline Native nativeLarger(Native a, Native b) {
  return _mm256_max_ps(a, b);
}
inline Native nativeSmaller(Native a, Native b) {
  return _mm256_min_ps(a, b);
}
inline Native nativeRoot(Native a) {
  return _mm256_sqrt_ps(a);
}
inline unsigned nativeBits(Native a, Native b) {
  return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LT_OQ)));
}
#else
constexpr int registerLanes = 4;
typedef __m128 Native;
inline Native nativeSplat(float v) {
  return _mm_set1_ps(v);
}
inline Native nativeLarger(Native a, Native b) {
  return _mm_max_ps(a, b);
}
inline Native nativeSmaller(Native a, Native b) {
  return _mm_min_ps(a, b);
}
inline Native nativeRoot(Native a) {
  return _mm_sqrt_ps(a);
}
inline unsigned nativeBits(Native a, Native b) {
  return static_cast<unsigned>(_mm_movemask_ps(_mm_cmplt_ps(a, b)));
}
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

/// Sixteen whole numbers.
using Ints = Mask;

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
  return each([&](int) { return static_cast<Register>(nativeSplat(v)); });
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
  return each([&](int k) { return static_cast<Register>(nativeLarger(a.r[k], b.r[k])); });
}
inline Lanes smaller(const Lanes& a, const Lanes& b) {
  return each([&](int k) { return static_cast<Register>(nativeSmaller(a.r[k], b.r[k])); });
}
inline Lanes magnitude(const Lanes& a) {
  return each(
      [&](int k) { return reinterpret_cast<Register>(reinterpret_cast<MaskRegister>(a.r[k]) & 0x7fffffff); });
}
inline Lanes squareRoot(const Lanes& a) {
  return each([&](int k) { return static_cast<Register>(nativeRoot(a.r[k])); });
}

inline Ints truncated(const Lanes& a) {
  return eachMask([&](int k) { return __builtin_convertvector(a.r[k], MaskRegister); });
}
inline Lanes toFloat(const Ints& a) {
  return each([&](int k) { return __builtin_convertvector(a.r[k], Register); });
}
inline Ints operator+(const Ints& a, const Ints& b) {
  return eachMask([&](int k) { return a.r[k] + b.r[k]; });
}
inline Ints operator+(const Ints& a, int b) {
  return eachMask([&](int k) { return a.r[k] + b; });
}
inline Ints operator*(int a, const Ints& b) {
  return eachMask([&](int k) { return a * b.r[k]; });
}
inline Ints operator&(const Ints& a, int b) {
  return eachMask([&](int k) { return a.r[k] & b; });
}
inline Ints operator<<(const Ints& a, int b) {
  return eachMask([&](int k) { return a.r[k] << b; });
}
inline Ints operator>>(const Ints& a, int b) {
  return eachMask([&](int k) { return a.r[k] >> b; });
}
inline Mask operator<(const Ints& a, int b) {
  return eachMask([&](int k) { return a.r[k] < b; });
}

/// The 32 bits that begin at each of the elements `base[at]`.
template <class Element>
inline Ints gather(const Element* base, const Ints& at) {
  return eachMask([&](int k) -> MaskRegister {
#if defined(__AVX512F__)
    return reinterpret_cast<MaskRegister>(
        _mm512_i32gather_epi32(reinterpret_cast<__m512i>(at.r[k]), base, sizeof(Element)));
#elif defined(__AVX2__)
    return reinterpret_cast<MaskRegister>(_mm256_i32gather_epi32(
        reinterpret_cast<const int*>(base), reinterpret_cast<__m256i>(at.r[k]), sizeof(Element)));
#else
    MaskRegister out;
    for (int lane = 0; lane < registerLanes; ++lane) {
      int bits;
      __builtin_memcpy(&bits, base + at.r[k][lane], sizeof bits);
      out[lane] = bits;
    }
    return out;
#endif
  });
}

/// Bit k is set where lane k of a is less than that of b.
inline unsigned bitsWhereLess(const Lanes& a, const Lanes& b) {
  unsigned bits = 0;
  for (int k = 0; k < registers; ++k) bits |= nativeBits(a.r[k], b.r[k]) << k * registerLanes;
  return bits;
}

/// Bit k is set where lane k of the mask is.
inline unsigned bitsOf(const Mask& m) {
  unsigned bits = 0;
  for (int k = 0; k < registers; ++k) {
#if defined(__AVX512F__)
    bits |= _mm512_test_epi32_mask(reinterpret_cast<__m512i>(m.r[k]), reinterpret_cast<__m512i>(m.r[k]));
#elif defined(__AVX__)
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

inline float laneOf(const Lanes& a, int lane) {
  return a.r[lane / registerLanes][lane % registerLanes];
}

inline int laneOf(const Ints& a, int lane) {
  return a.r[lane / registerLanes][lane % registerLanes];
}

/// Folds the lanes k and k + 8, then k and k + 4: what is left of a sum or an extremum.
template <class Operation>
inline __attribute__((always_inline)) __m128 folded(const Lanes& a, Operation operation) {
#if defined(__AVX512F__)
  const __m512 all = a.r[0];
  const __m256 half = operation(_mm512_castps512_ps256(all), _mm512_extractf32x8_ps(all, 1));
  return operation(_mm256_castps256_ps128(half), _mm256_extractf128_ps(half, 1));
#elif defined(__AVX__)
  const __m256 half = operation(static_cast<__m256>(a.r[0]), static_cast<__m256>(a.r[1]));
  return operation(_mm256_castps256_ps128(half), _mm256_extractf128_ps(half, 1));
#else
  return operation(operation(static_cast<__m128>(a.r[0]), static_cast<__m128>(a.r[2])),
                   operation(static_cast<__m128>(a.r[1]), static_cast<__m128>(a.r[3])));
#endif
}

/// Four sums, each in an order that every instruction set keeps: lanes k and k + 8, then k and k + 4, ...
inline void sums(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d, float out[4]) {
  const auto add = [](auto x, auto y) { return x + y; };
  __m128 r0 = folded(a, add), r1 = folded(b, add), r2 = folded(c, add), r3 = folded(d, add);
  _MM_TRANSPOSE4_PS(r0, r1, r2, r3);
  _mm_storeu_ps(out, (r0 + r2) + (r1 + r3));
}
inline float largest(const Lanes& a) {
  const auto larger = [](auto x, auto y) { return x > y ? x : y; };
  alignas(16) float v[4];
  _mm_store_ps(v, folded(a, larger));
  const float even = v[0] > v[2] ? v[0] : v[2], odd = v[1] > v[3] ? v[1] : v[3];
  return even > odd ? even : odd;
}
inline float smallest(const Lanes& a) {
  return -largest(splat(0.0f) - a);
}

}  // namespace
}  // namespace packmesh
