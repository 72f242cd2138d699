// One register of the instruction set: 8 floats of AVX2.
#pragma once

#include <immintrin.h>

#include "learn/network/kernels/kernel_set.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

using Register = __m256;
using RegisterInts = __m256i;
using RegisterMask = __m256;
inline constexpr int kRegisterLanes = 8;
inline constexpr int kTileVectors = 1;  ///< of 16 registers, 12 hold sums
inline constexpr int kTileRows = 6;

SKYBODY_KERNEL Register register_load(const float* p) { return _mm256_loadu_ps(p); }
SKYBODY_KERNEL void register_store(float* p, Register a) { _mm256_storeu_ps(p, a); }
SKYBODY_KERNEL Register register_set(float a) { return _mm256_set1_ps(a); }
SKYBODY_KERNEL Register register_add(Register a, Register b) { return _mm256_add_ps(a, b); }
SKYBODY_KERNEL Register register_sub(Register a, Register b) { return _mm256_sub_ps(a, b); }
SKYBODY_KERNEL Register register_mul(Register a, Register b) { return _mm256_mul_ps(a, b); }
SKYBODY_KERNEL Register register_div(Register a, Register b) { return _mm256_div_ps(a, b); }
SKYBODY_KERNEL Register register_fma(Register a, Register b, Register c) {
  return _mm256_fmadd_ps(a, b, c);
}
SKYBODY_KERNEL Register register_sqrt(Register a) { return _mm256_sqrt_ps(a); }
SKYBODY_KERNEL Register register_min(Register a, Register b) { return _mm256_min_ps(a, b); }
SKYBODY_KERNEL Register register_max(Register a, Register b) { return _mm256_max_ps(a, b); }
SKYBODY_KERNEL RegisterMask register_less(Register a, Register b) {
  return _mm256_cmp_ps(a, b, _CMP_LT_OQ);
}
SKYBODY_KERNEL Register register_select(RegisterMask m, Register a, Register b) {
  return _mm256_blendv_ps(b, a, m);
}
SKYBODY_KERNEL RegisterInts register_load(const uint32_t* p) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
}
SKYBODY_KERNEL RegisterInts register_set(int32_t a) { return _mm256_set1_epi32(a); }
SKYBODY_KERNEL RegisterInts register_add(RegisterInts a, RegisterInts b) {
  return _mm256_add_epi32(a, b);
}
SKYBODY_KERNEL RegisterInts register_and(RegisterInts a, RegisterInts b) {
  return _mm256_and_si256(a, b);
}
SKYBODY_KERNEL RegisterInts register_xor(RegisterInts a, RegisterInts b) {
  return _mm256_xor_si256(a, b);
}
template <int N>
SKYBODY_KERNEL RegisterInts register_left(RegisterInts a) {
  return _mm256_slli_epi32(a, N);
}
template <int N>
SKYBODY_KERNEL RegisterInts register_right(RegisterInts a) {
  return _mm256_srli_epi32(a, N);
}
/// blendv only uses the sign.
SKYBODY_KERNEL RegisterMask register_negative(RegisterInts a) { return _mm256_castsi256_ps(a); }
SKYBODY_KERNEL Register register_float(RegisterInts a) { return _mm256_cvtepi32_ps(a); }
SKYBODY_KERNEL RegisterInts register_bits(Register a) { return _mm256_castps_si256(a); }
SKYBODY_KERNEL Register register_of_bits(RegisterInts a) { return _mm256_castsi256_ps(a); }

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
