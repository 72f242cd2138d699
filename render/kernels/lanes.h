// Vectors of floats of the instruction set's width: arithmetic by operators, one IEEE 754 operation
// per lane, and the functions below. min and max return b if one is NaN; comparisons with NaN are
// false. Every set gives the same bits.
#pragma once

#include <stdint.h>

#if defined(__AVX512F__) || defined(__AVX2__) || defined(__SSE4_2__)
#include <immintrin.h>
#endif

/// SKYBODY_KERNEL_SET is the instruction set that the file is compiled for (CMakeLists.txt), and
/// the namespace of its content: the linker must not replace one set's copy of an inline function
/// by another's.
#define SKYBODY_RENDER inline __attribute__((always_inline))

namespace skybody::render::kernels::SKYBODY_KERNEL_SET {

#if defined(SKYBODY_KERNEL_LANES)  // a width for tests, without intrinsics
inline constexpr int kLanes = SKYBODY_KERNEL_LANES;
#elif defined(__AVX512F__)
inline constexpr int kLanes = 16;
#elif defined(__AVX2__)
inline constexpr int kLanes = 8;
#else
inline constexpr int kLanes = 4;
#endif

typedef float Floats __attribute__((vector_size(4 * kLanes)));
typedef int32_t Ints __attribute__((vector_size(4 * kLanes)));

SKYBODY_RENDER Floats floats(float a) { return Floats{} + a; }
SKYBODY_RENDER Ints ints(int32_t a) { return Ints{} + a; }
template <class Vector, class Value>
SKYBODY_RENDER Vector load(const Value* p) {
  Vector v;
  __builtin_memcpy(&v, p, sizeof(v));
  return v;
}
template <class Vector, class Value>
SKYBODY_RENDER void store(const Vector& v, Value* p) {
  __builtin_memcpy(p, &v, sizeof(v));
}

#if defined(__AVX512F__) && !defined(SKYBODY_KERNEL_LANES)

struct Mask {
  __mmask16 bits;
};
SKYBODY_RENDER Mask operator&(Mask a, Mask b) { return {_kand_mask16(a.bits, b.bits)}; }
/// Bit i is lane i.
SKYBODY_RENDER uint32_t lanes_of(Mask a) { return a.bits; }
SKYBODY_RENDER Mask greater(Floats a, Floats b) { return {_mm512_cmp_ps_mask(a, b, _CMP_GT_OQ)}; }
SKYBODY_RENDER Mask at_least(Floats a, Floats b) { return {_mm512_cmp_ps_mask(a, b, _CMP_GE_OQ)}; }
SKYBODY_RENDER Mask equal(Floats a, Floats b) { return {_mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ)}; }
SKYBODY_RENDER Mask equal(Ints a, Ints b) {
  return {_mm512_cmpeq_epi32_mask(reinterpret_cast<__m512i>(a), reinterpret_cast<__m512i>(b))};
}
SKYBODY_RENDER Floats select(Mask m, Floats a, Floats b) {
  return _mm512_mask_blend_ps(m.bits, b, a);
}
SKYBODY_RENDER Ints select(Mask m, Ints a, Ints b) {
  return reinterpret_cast<Ints>(
      _mm512_mask_blend_epi32(m.bits, reinterpret_cast<__m512i>(b), reinterpret_cast<__m512i>(a)));
}
SKYBODY_RENDER Floats min(Floats a, Floats b) { return _mm512_min_ps(a, b); }
SKYBODY_RENDER Floats max(Floats a, Floats b) { return _mm512_max_ps(a, b); }
SKYBODY_RENDER Floats sqrt(Floats a) { return _mm512_sqrt_ps(a); }

#else

struct Mask {
  Ints bits;  ///< all bits of a lane, or none
};
SKYBODY_RENDER Mask operator&(Mask a, Mask b) { return {a.bits & b.bits}; }
SKYBODY_RENDER Mask greater(Floats a, Floats b) { return {a > b}; }
SKYBODY_RENDER Mask at_least(Floats a, Floats b) { return {a >= b}; }
SKYBODY_RENDER Mask equal(Floats a, Floats b) { return {a == b}; }
SKYBODY_RENDER Mask equal(Ints a, Ints b) { return {a == b}; }
SKYBODY_RENDER Ints select(Mask m, Ints a, Ints b) { return (a & m.bits) | (b & ~m.bits); }

#if defined(__AVX2__) && !defined(SKYBODY_KERNEL_LANES)
SKYBODY_RENDER uint32_t lanes_of(Mask a) {
  return static_cast<uint32_t>(_mm256_movemask_ps(reinterpret_cast<__m256>(a.bits)));
}
SKYBODY_RENDER Floats select(Mask m, Floats a, Floats b) {
  return _mm256_blendv_ps(b, a, reinterpret_cast<__m256>(m.bits));
}
SKYBODY_RENDER Floats min(Floats a, Floats b) { return _mm256_min_ps(a, b); }
SKYBODY_RENDER Floats max(Floats a, Floats b) { return _mm256_max_ps(a, b); }
SKYBODY_RENDER Floats sqrt(Floats a) { return _mm256_sqrt_ps(a); }
#elif defined(__SSE4_2__) && !defined(SKYBODY_KERNEL_LANES)
SKYBODY_RENDER uint32_t lanes_of(Mask a) {
  return static_cast<uint32_t>(_mm_movemask_ps(reinterpret_cast<__m128>(a.bits)));
}
SKYBODY_RENDER Floats select(Mask m, Floats a, Floats b) {
  return _mm_blendv_ps(b, a, reinterpret_cast<__m128>(m.bits));
}
SKYBODY_RENDER Floats min(Floats a, Floats b) { return _mm_min_ps(a, b); }
SKYBODY_RENDER Floats max(Floats a, Floats b) { return _mm_max_ps(a, b); }
SKYBODY_RENDER Floats sqrt(Floats a) { return _mm_sqrt_ps(a); }
#else
SKYBODY_RENDER uint32_t lanes_of(Mask a) {
  uint32_t lanes = 0;
  for (int i = 0; i < kLanes; ++i) lanes |= a.bits[i] != 0 ? 1u << i : 0u;
  return lanes;
}
SKYBODY_RENDER Floats select(Mask m, Floats a, Floats b) { return m.bits ? a : b; }
SKYBODY_RENDER Floats min(Floats a, Floats b) { return a < b ? a : b; }
SKYBODY_RENDER Floats max(Floats a, Floats b) { return a > b ? a : b; }
SKYBODY_RENDER Floats sqrt(Floats a) {
  for (int i = 0; i < kLanes; ++i) a[i] = __builtin_sqrtf(a[i]);
  return a;
}
#endif
#endif

SKYBODY_RENDER bool any(Mask a) { return lanes_of(a) != 0; }
SKYBODY_RENDER Floats abs(Floats a) {
  return reinterpret_cast<Floats>(reinterpret_cast<Ints>(a) & 0x7fffffff);
}

}  // namespace skybody::render::kernels::SKYBODY_KERNEL_SET
