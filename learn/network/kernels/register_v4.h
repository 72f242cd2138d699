// One register of the instruction set: 16 floats of AVX-512.
#pragma once

#include <immintrin.h>

#include "learn/network/kernels/kernel_set.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

using Register = __m512;
using RegisterInts = __m512i;
using RegisterMask = __mmask16;
inline constexpr int kRegisterLanes = 16;
inline constexpr int kTileVectors = 4;  ///< of 32 registers, 24 hold sums
inline constexpr int kTileRows = 6;

SKYBODY_KERNEL Register register_load(const float* p) { return _mm512_loadu_ps(p); }
SKYBODY_KERNEL void register_store(float* p, Register a) { _mm512_storeu_ps(p, a); }
SKYBODY_KERNEL Register register_set(float a) { return _mm512_set1_ps(a); }
SKYBODY_KERNEL Register register_add(Register a, Register b) { return _mm512_add_ps(a, b); }
SKYBODY_KERNEL Register register_sub(Register a, Register b) { return _mm512_sub_ps(a, b); }
SKYBODY_KERNEL Register register_mul(Register a, Register b) { return _mm512_mul_ps(a, b); }
SKYBODY_KERNEL Register register_div(Register a, Register b) { return _mm512_div_ps(a, b); }
SKYBODY_KERNEL Register register_fma(Register a, Register b, Register c) {
  return _mm512_fmadd_ps(a, b, c);
}
SKYBODY_KERNEL Register register_sqrt(Register a) { return _mm512_sqrt_ps(a); }
SKYBODY_KERNEL Register register_min(Register a, Register b) { return _mm512_min_ps(a, b); }
SKYBODY_KERNEL Register register_max(Register a, Register b) { return _mm512_max_ps(a, b); }
SKYBODY_KERNEL RegisterMask register_less(Register a, Register b) {
  return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
}
SKYBODY_KERNEL Register register_select(RegisterMask m, Register a, Register b) {
  return _mm512_mask_blend_ps(m, b, a);
}
SKYBODY_KERNEL RegisterInts register_load(const uint32_t* p) { return _mm512_loadu_si512(p); }
SKYBODY_KERNEL RegisterInts register_set(int32_t a) { return _mm512_set1_epi32(a); }
SKYBODY_KERNEL RegisterInts register_add(RegisterInts a, RegisterInts b) {
  return _mm512_add_epi32(a, b);
}
SKYBODY_KERNEL RegisterInts register_and(RegisterInts a, RegisterInts b) {
  return _mm512_and_si512(a, b);
}
SKYBODY_KERNEL RegisterInts register_xor(RegisterInts a, RegisterInts b) {
  return _mm512_xor_si512(a, b);
}
template <int N>
SKYBODY_KERNEL RegisterInts register_left(RegisterInts a) {
  return _mm512_slli_epi32(a, N);
}
template <int N>
SKYBODY_KERNEL RegisterInts register_right(RegisterInts a) {
  return _mm512_srli_epi32(a, N);
}
SKYBODY_KERNEL RegisterMask register_negative(RegisterInts a) {
  return _mm512_cmplt_epi32_mask(a, _mm512_setzero_si512());
}
SKYBODY_KERNEL Register register_float(RegisterInts a) { return _mm512_cvtepi32_ps(a); }
SKYBODY_KERNEL RegisterInts register_bits(Register a) { return _mm512_castps_si512(a); }
SKYBODY_KERNEL Register register_of_bits(RegisterInts a) { return _mm512_castsi512_ps(a); }

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
