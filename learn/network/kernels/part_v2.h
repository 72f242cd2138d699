// One register of the instruction set: 4 floats of SSE4.2.
#pragma once

#include <nmmintrin.h>

#include "learn/network/kernels/kernel_set.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

using Part = __m128;
using PartInts = __m128i;
using PartMask = __m128;
inline constexpr int kPartLanes = 4;
inline constexpr int kTileVectors = 1;  ///< of 16 registers, 8 hold sums
inline constexpr int kTileRows = 2;

SKYBODY_KERNEL Part part_load(const float* p) { return _mm_loadu_ps(p); }
SKYBODY_KERNEL void part_store(float* p, Part a) { _mm_storeu_ps(p, a); }
SKYBODY_KERNEL Part part_set(float a) { return _mm_set1_ps(a); }
SKYBODY_KERNEL Part part_add(Part a, Part b) { return _mm_add_ps(a, b); }
SKYBODY_KERNEL Part part_sub(Part a, Part b) { return _mm_sub_ps(a, b); }
SKYBODY_KERNEL Part part_mul(Part a, Part b) { return _mm_mul_ps(a, b); }
SKYBODY_KERNEL Part part_div(Part a, Part b) { return _mm_div_ps(a, b); }
/// Rounds twice: the set has no fused multiply-add.
SKYBODY_KERNEL Part part_fma(Part a, Part b, Part c) { return _mm_add_ps(_mm_mul_ps(a, b), c); }
SKYBODY_KERNEL Part part_sqrt(Part a) { return _mm_sqrt_ps(a); }
SKYBODY_KERNEL Part part_min(Part a, Part b) { return _mm_min_ps(a, b); }
SKYBODY_KERNEL Part part_max(Part a, Part b) { return _mm_max_ps(a, b); }
SKYBODY_KERNEL PartMask part_less(Part a, Part b) { return _mm_cmplt_ps(a, b); }
SKYBODY_KERNEL Part part_select(PartMask m, Part a, Part b) { return _mm_blendv_ps(b, a, m); }
SKYBODY_KERNEL PartInts part_load(const uint32_t* p) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p));
}
SKYBODY_KERNEL PartInts part_set(int32_t a) { return _mm_set1_epi32(a); }
SKYBODY_KERNEL PartInts part_add(PartInts a, PartInts b) { return _mm_add_epi32(a, b); }
SKYBODY_KERNEL PartInts part_and(PartInts a, PartInts b) { return _mm_and_si128(a, b); }
SKYBODY_KERNEL PartInts part_xor(PartInts a, PartInts b) { return _mm_xor_si128(a, b); }
template <int N>
SKYBODY_KERNEL PartInts part_left(PartInts a) {
  return _mm_slli_epi32(a, N);
}
template <int N>
SKYBODY_KERNEL PartInts part_right(PartInts a) {
  return _mm_srli_epi32(a, N);
}
/// blendv only uses the sign.
SKYBODY_KERNEL PartMask part_negative(PartInts a) { return _mm_castsi128_ps(a); }
SKYBODY_KERNEL Part part_float(PartInts a) { return _mm_cvtepi32_ps(a); }
SKYBODY_KERNEL PartInts part_bits(Part a) { return _mm_castps_si128(a); }
SKYBODY_KERNEL Part part_of_bits(PartInts a) { return _mm_castsi128_ps(a); }

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
