// One register of the instruction set: 16 floats of AVX-512.
#pragma once

#include <immintrin.h>

#include "learn/network/kernels/kernel_set.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

using Part = __m512;
using PartInts = __m512i;
using PartMask = __mmask16;
inline constexpr int kPartLanes = 16;
inline constexpr int kTileVectors = 4;  ///< of 32 registers, 24 hold sums
inline constexpr int kTileRows = 6;

SKYBODY_KERNEL Part part_load(const float* p) { return _mm512_loadu_ps(p); }
SKYBODY_KERNEL void part_store(float* p, Part a) { _mm512_storeu_ps(p, a); }
SKYBODY_KERNEL Part part_set(float a) { return _mm512_set1_ps(a); }
SKYBODY_KERNEL Part part_add(Part a, Part b) { return _mm512_add_ps(a, b); }
SKYBODY_KERNEL Part part_sub(Part a, Part b) { return _mm512_sub_ps(a, b); }
SKYBODY_KERNEL Part part_mul(Part a, Part b) { return _mm512_mul_ps(a, b); }
SKYBODY_KERNEL Part part_div(Part a, Part b) { return _mm512_div_ps(a, b); }
SKYBODY_KERNEL Part part_fma(Part a, Part b, Part c) { return _mm512_fmadd_ps(a, b, c); }
SKYBODY_KERNEL Part part_sqrt(Part a) { return _mm512_sqrt_ps(a); }
SKYBODY_KERNEL Part part_min(Part a, Part b) { return _mm512_min_ps(a, b); }
SKYBODY_KERNEL Part part_max(Part a, Part b) { return _mm512_max_ps(a, b); }
SKYBODY_KERNEL PartMask part_less(Part a, Part b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
SKYBODY_KERNEL Part part_select(PartMask m, Part a, Part b) {
  return _mm512_mask_blend_ps(m, b, a);
}
SKYBODY_KERNEL PartInts part_load(const uint32_t* p) { return _mm512_loadu_si512(p); }
SKYBODY_KERNEL PartInts part_set(int32_t a) { return _mm512_set1_epi32(a); }
SKYBODY_KERNEL PartInts part_add(PartInts a, PartInts b) { return _mm512_add_epi32(a, b); }
SKYBODY_KERNEL PartInts part_and(PartInts a, PartInts b) { return _mm512_and_si512(a, b); }
SKYBODY_KERNEL PartInts part_xor(PartInts a, PartInts b) { return _mm512_xor_si512(a, b); }
template <int N>
SKYBODY_KERNEL PartInts part_left(PartInts a) {
  return _mm512_slli_epi32(a, N);
}
template <int N>
SKYBODY_KERNEL PartInts part_right(PartInts a) {
  return _mm512_srli_epi32(a, N);
}
SKYBODY_KERNEL PartMask part_negative(PartInts a) {
  return _mm512_cmplt_epi32_mask(a, _mm512_setzero_si512());
}
SKYBODY_KERNEL Part part_float(PartInts a) { return _mm512_cvtepi32_ps(a); }
SKYBODY_KERNEL PartInts part_bits(Part a) { return _mm512_castps_si512(a); }
SKYBODY_KERNEL Part part_of_bits(PartInts a) { return _mm512_castsi512_ps(a); }

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
