// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Vectors of sixteen floats, in as many registers of the current instruction set as needed. Every
/// operation is one IEEE operation per lane, so all instruction sets give the same bits.
///
/// Only for the translation units of kernels: everything has internal linkage, because each unit is compiled
/// for a different instruction set.
#pragma once

#include <cstdint>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace packmesh {
namespace {

constexpr int laneCount = 16;

/// One register. Compiler vector types are lowered well only if they fit one register.
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

/// Operations that vector types lack, or that g++ compiles to several instructions: maximum (a > b ? a : b),
/// minimum, square root, bits of a mask, and gather (the 32 bits that begin at each element `base[at]`).
#if defined(__AVX512F__)
inline Register larger(Register a, Register b) {
  return _mm512_max_ps(a, b);
}
inline Register smaller(Register a, Register b) {
  return _mm512_min_ps(a, b);
}
inline Register squareRoot(Register a) {
  return _mm512_sqrt_ps(a);
}
inline unsigned bitsOf(MaskRegister m) {
  return _mm512_test_epi32_mask(reinterpret_cast<__m512i>(m), reinterpret_cast<__m512i>(m));
}
template <class Element>
inline MaskRegister gather(const Element* base, MaskRegister at) {
  return reinterpret_cast<MaskRegister>(
      _mm512_i32gather_epi32(reinterpret_cast<__m512i>(at), base, sizeof(Element)));
}
#elif defined(__AVX2__)
inline Register larger(Register a, Register b) {
  return _mm256_max_ps(a, b);
}
inline Register smaller(Register a, Register b) {
  return _mm256_min_ps(a, b);
}
inline Register squareRoot(Register a) {
  return _mm256_sqrt_ps(a);
}
inline unsigned bitsOf(MaskRegister m) {
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(m)));
}
template <class Element>
inline MaskRegister gather(const Element* base, MaskRegister at) {
  return reinterpret_cast<MaskRegister>(_mm256_i32gather_epi32(
      reinterpret_cast<const int*>(base), reinterpret_cast<__m256i>(at), sizeof(Element)));
}
#else
inline Register larger(Register a, Register b) {
  return a > b ? a : b;
}
inline Register smaller(Register a, Register b) {
  return a < b ? a : b;
}
inline Register squareRoot(Register a) {
  Register out;
  for (int lane = 0; lane < registerLanes; ++lane) out[lane] = __builtin_sqrtf(a[lane]);
  return out;
}
template <class Element>
inline MaskRegister gather(const Element* base, MaskRegister at) {
  MaskRegister out;
  for (int lane = 0; lane < registerLanes; ++lane)
    __builtin_memcpy(reinterpret_cast<int*>(&out) + lane, base + at[lane], sizeof(int));
  return out;
}
#endif

struct Mask {
  MaskRegister r[registers];
};

struct Lanes {
  Register r[registers];
};

/// Sixteen integers.
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
  return each([&](int) { return v - Register{}; });  // v + 0 would turn -0 into +0
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
  return each([&](int k) { return larger(a.r[k], b.r[k]); });
}
inline Lanes smaller(const Lanes& a, const Lanes& b) {
  return each([&](int k) { return smaller(a.r[k], b.r[k]); });
}
inline Lanes magnitude(const Lanes& a) {
  return each(
      [&](int k) { return reinterpret_cast<Register>(reinterpret_cast<MaskRegister>(a.r[k]) & 0x7fffffff); });
}
inline Lanes squareRoot(const Lanes& a) {
  return each([&](int k) { return squareRoot(a.r[k]); });
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

template <class Element>
inline Ints gather(const Element* base, const Ints& at) {
  return eachMask([&](int k) { return gather(base, at.r[k]); });
}

/// Of elements that other threads store meanwhile, with release: each is read as a whole, and what was stored
/// before it is seen afterwards. The gathers of AVX2 and AVX-512 read every aligned element in one access,
/// and these processors do not exchange reads; only the compiler must not either.
inline Ints gatherAcquire(const std::int32_t* base, const Ints& at) {
#if defined(__AVX512F__) || defined(__AVX2__)
  const Ints out = gather(base, at);
  __atomic_signal_fence(__ATOMIC_ACQUIRE);
  return out;
#else
  return eachMask([&](int k) {
    MaskRegister out{};
    for (int lane = 0; lane < registerLanes; ++lane)
      out[lane] = __atomic_load_n(base + at.r[k][lane], __ATOMIC_ACQUIRE);
    return out;
  });
#endif
}

/// Bit k is set if lane k of the mask is set.
inline unsigned bitsOf(const Mask& m) {
#if defined(__AVX512F__)
  return bitsOf(m.r[0]);
#elif defined(__AVX2__)
  return bitsOf(m.r[0]) | bitsOf(m.r[1]) << 8;
#else
  MaskRegister bits{};
  for (int k = 0; k < registers; ++k) bits |= m.r[k] & (MaskRegister{1, 2, 4, 8} << k * registerLanes);
  return static_cast<unsigned>((bits[0] | bits[1]) | (bits[2] | bits[3]));
#endif
}

/// Bit k is set if lane k of a is less than lane k of b.
inline unsigned bitsWhereLess(const Lanes& a, const Lanes& b) {
#if defined(__AVX512F__)
  return _mm512_cmp_ps_mask(a.r[0], b.r[0], _CMP_LT_OQ);
#else
  return bitsOf(a < b);
#endif
}

typedef float Four __attribute__((vector_size(16)));
typedef float UnalignedFour __attribute__((vector_size(16), may_alias, aligned(4)));

/// Lane k is p[k % 4].
inline Lanes loadAllFourTimes(const float* p) {
  return each([&](int) -> Register {
#if defined(__AVX512F__)
    return _mm512_broadcast_f32x4(_mm_loadu_ps(p));
#elif defined(__AVX2__)
    return _mm256_broadcast_ps(reinterpret_cast<const __m128*>(p));
#else
    return *reinterpret_cast<const UnalignedFour*>(p);
#endif
  });
}

/// Lane k is p[k / 4].
inline Lanes loadEachFourTimes(const float* p) {
#if defined(__AVX512F__)
  const Register all = loadAllFourTimes(p).r[0];
  return {{__builtin_shufflevector(all, all, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3)}};
#elif defined(__AVX2__)
  const Register all = loadAllFourTimes(p).r[0];
  return {{__builtin_shufflevector(all, all, 0, 0, 0, 0, 1, 1, 1, 1),
           __builtin_shufflevector(all, all, 2, 2, 2, 2, 3, 3, 3, 3)}};
#else
  return each([&](int k) { return p[k] - Register{}; });
#endif
}

inline void store(const Lanes& a, float* out) {
  for (int k = 0; k < registers; ++k) *reinterpret_cast<UnalignedRegister*>(out + k * registerLanes) = a.r[k];
}

/// Writes the lanes whose bit is set one after the other. Writes all of out[0 ... 15].
inline void storeWhere(unsigned bits, const Lanes& a, float* out) {
#if defined(__AVX512F__)
  _mm512_storeu_ps(out, _mm512_maskz_compress_ps(static_cast<__mmask16>(bits), a.r[0]));
#else
  float all[laneCount];
  store(a, all);
  for (int k = 0; k < laneCount; ++k) out[k] = 0.0f;
  int n = 0;
  for (; bits != 0; bits &= bits - 1) out[n++] = all[__builtin_ctz(bits)];
#endif
}

inline float laneOf(const Lanes& a, int lane) {
  return a.r[lane / registerLanes][lane % registerLanes];
}

inline int laneOf(const Ints& a, int lane) {
  return a.r[lane / registerLanes][lane % registerLanes];
}

/// Combines lanes k and k + 8, then k and k + 4: the remaining four lanes of a sum or an extremum.
template <class Operation>
inline __attribute__((always_inline)) Four folded(const Lanes& a, Operation operation) {
#if defined(__AVX2__)
#if defined(__AVX512F__)
  const Register all = a.r[0];
  const auto eight = operation(__builtin_shufflevector(all, all, 0, 1, 2, 3, 4, 5, 6, 7),
                               __builtin_shufflevector(all, all, 8, 9, 10, 11, 12, 13, 14, 15));
#else
  const Register eight = operation(a.r[0], a.r[1]);
#endif
  return operation(__builtin_shufflevector(eight, eight, 0, 1, 2, 3),
                   __builtin_shufflevector(eight, eight, 4, 5, 6, 7));
#else
  return operation(operation(a.r[0], a.r[2]), operation(a.r[1], a.r[3]));
#endif
}

/// Four sums, in the same order for every instruction set: lanes k and k + 8, then k and k + 4, ...
inline void sums(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d, float out[4]) {
  const auto add = [](auto x, auto y) { return x + y; };
  const Four ab[2] = {folded(a, add), folded(b, add)}, cd[2] = {folded(c, add), folded(d, add)};
  // Even and odd lanes of two vectors at a time.
  const Four p =
      __builtin_shufflevector(ab[0], ab[1], 0, 4, 1, 5) + __builtin_shufflevector(ab[0], ab[1], 2, 6, 3, 7);
  const Four q =
      __builtin_shufflevector(cd[0], cd[1], 0, 4, 1, 5) + __builtin_shufflevector(cd[0], cd[1], 2, 6, 3, 7);
  *reinterpret_cast<UnalignedFour*>(out) =
      __builtin_shufflevector(p, q, 0, 1, 4, 5) + __builtin_shufflevector(p, q, 2, 3, 6, 7);
}
inline float largest(const Lanes& a) {
  const Four v = folded(a, [](auto x, auto y) { return x > y ? x : y; });
  const float even = v[0] > v[2] ? v[0] : v[2], odd = v[1] > v[3] ? v[1] : v[3];
  return even > odd ? even : odd;
}
inline float smallest(const Lanes& a) {
  return -largest(splat(0.0f) - a);
}

}  // namespace
}  // namespace packmesh
