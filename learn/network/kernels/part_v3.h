// One register of the instruction set: 8 floats of AVX2.
#pragma once

#include <immintrin.h>

#include "learn/network/kernels/kernel_set.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

using Part = __m256;
using PartInts = __m256i;
using PartMask = __m256;
inline constexpr int kPartLanes = 8;
inline constexpr int kTileVectors = 1;  ///< of 16 registers, 12 hold sums
inline constexpr int kTileRows = 6;

SKYBODY_KERNEL Part part_load(const float* p) { return _mm256_loadu_ps(p); }
SKYBODY_KERNEL void part_store(float* p, Part a) { _mm256_storeu_ps(p, a); }
SKYBODY_KERNEL Part part_set(float a) { return _mm256_set1_ps(a); }
SKYBODY_KERNEL Part part_add(Part a, Part b) { return _mm256_add_ps(a, b); }
SKYBODY_KERNEL Part part_sub(Part a, Part b) { return _mm256_sub_ps(a, b); }
SKYBODY_KERNEL Part part_mul(Part a, Part b) { return _mm256_mul_ps(a, b); }
SKYBODY_KERNEL Part part_div(Part a, Part b) { return _mm256_div_ps(a, b); }
SKYBODY_KERNEL Part part_fma(Part a, Part b, Part c) { return _mm256_fmadd_ps(a, b, c); }
SKYBODY_KERNEL Part part_sqrt(Part a) { return _mm256_sqrt_ps(a); }
SKYBODY_KERNEL Part part_min(Part a, Part b) { return _mm256_min_ps(a, b); }
SKYBODY_KERNEL Part part_max(Part a, Part b) { return _mm256_max_ps(a, b); }
SKYBODY_KERNEL PartMask part_less(Part a, Part b) { return _mm256_cmp_ps(a, b, _CMP_LT_OQ); }
SKYBODY_KERNEL Part part_select(PartMask m, Part a, Part b) { return _mm256_blendv_ps(b, a, m); }
SKYBODY_KERNEL PartInts part_load(const uint32_t* p) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
}
SKYBODY_KERNEL PartInts part_set(int32_t a) { return _mm256_set1_epi32(a); }
SKYBODY_KERNEL PartInts part_add(PartInts a, PartInts b) { return _mm256_add_epi32(a, b); }
SKYBODY_KERNEL PartInts part_and(PartInts a, PartInts b) { return _mm256_and_si256(a, b); }
SKYBODY_KERNEL PartInts part_xor(PartInts a, PartInts b) { return _mm256_xor_si256(a, b); }
template <int N>
SKYBODY_KERNEL PartInts part_left(PartInts a) {
  return _mm256_slli_epi32(a, N);
}
template <int N>
SKYBODY_KERNEL PartInts part_right(PartInts a) {
  return _mm256_srli_epi32(a, N);
}
/// blendv only uses the sign.
SKYBODY_KERNEL PartMask part_negative(PartInts a) { return _mm256_castsi256_ps(a); }
SKYBODY_KERNEL Part part_float(PartInts a) { return _mm256_cvtepi32_ps(a); }
SKYBODY_KERNEL PartInts part_bits(Part a) { return _mm256_castps_si256(a); }
SKYBODY_KERNEL Part part_of_bits(PartInts a) { return _mm256_castsi256_ps(a); }

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
