// One register of the instruction set: 4 floats of SSE4.2.
#pragma once

#include <nmmintrin.h>

#include "learn/network/kernels/kernel_set.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

using Register = __m128;
using RegisterInts = __m128i;
using RegisterMask = __m128;
inline constexpr int kRegisterLanes = 4;
inline constexpr int kTileVectors = 1;  ///< of 16 registers, 8 hold sums
inline constexpr int kTileRows = 2;

SKYBODY_KERNEL Register register_load(const float* p) { return _mm_loadu_ps(p); }
SKYBODY_KERNEL void register_store(float* p, Register a) { _mm_storeu_ps(p, a); }
SKYBODY_KERNEL Register register_set(float a) { return _mm_set1_ps(a); }
SKYBODY_KERNEL Register register_add(Register a, Register b) { return _mm_add_ps(a, b); }
SKYBODY_KERNEL Register register_sub(Register a, Register b) { return _mm_sub_ps(a, b); }
SKYBODY_KERNEL Register register_mul(Register a, Register b) { return _mm_mul_ps(a, b); }
SKYBODY_KERNEL Register register_div(Register a, Register b) { return _mm_div_ps(a, b); }
/// Rounds twice: the set has no fused multiply-add.
SKYBODY_KERNEL Register register_fma(Register a, Register b, Register c) {
  return _mm_add_ps(_mm_mul_ps(a, b), c);
}
SKYBODY_KERNEL Register register_sqrt(Register a) { return _mm_sqrt_ps(a); }
SKYBODY_KERNEL Register register_min(Register a, Register b) { return _mm_min_ps(a, b); }
SKYBODY_KERNEL Register register_max(Register a, Register b) { return _mm_max_ps(a, b); }
SKYBODY_KERNEL RegisterMask register_less(Register a, Register b) { return _mm_cmplt_ps(a, b); }
SKYBODY_KERNEL Register register_select(RegisterMask m, Register a, Register b) {
  return _mm_blendv_ps(b, a, m);
}
SKYBODY_KERNEL RegisterInts register_load(const uint32_t* p) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p));
}
SKYBODY_KERNEL RegisterInts register_set(int32_t a) { return _mm_set1_epi32(a); }
SKYBODY_KERNEL RegisterInts register_add(RegisterInts a, RegisterInts b) {
  return _mm_add_epi32(a, b);
}
SKYBODY_KERNEL RegisterInts register_and(RegisterInts a, RegisterInts b) {
  return _mm_and_si128(a, b);
}
SKYBODY_KERNEL RegisterInts register_xor(RegisterInts a, RegisterInts b) {
  return _mm_xor_si128(a, b);
}
template <int N>
SKYBODY_KERNEL RegisterInts register_left(RegisterInts a) {
  return _mm_slli_epi32(a, N);
}
template <int N>
SKYBODY_KERNEL RegisterInts register_right(RegisterInts a) {
  return _mm_srli_epi32(a, N);
}
/// blendv only uses the sign.
SKYBODY_KERNEL RegisterMask register_negative(RegisterInts a) { return _mm_castsi128_ps(a); }
SKYBODY_KERNEL Register register_float(RegisterInts a) { return _mm_cvtepi32_ps(a); }
SKYBODY_KERNEL RegisterInts register_bits(Register a) { return _mm_castps_si128(a); }
SKYBODY_KERNEL Register register_of_bits(RegisterInts a) { return _mm_castsi128_ps(a); }

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
