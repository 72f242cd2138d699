// One float per part; the compiler vectorizes loops over sixteen parts by itself.
#pragma once

#include "learn/network/kernels/kernel_set.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

using Part = float;
using PartInts = int32_t;
using PartMask = bool;
inline constexpr int kPartLanes = 1;
inline constexpr int kTileVectors = 1;
inline constexpr int kTileRows = 2;

SKYBODY_KERNEL Part part_load(const float* p) { return *p; }
SKYBODY_KERNEL void part_store(float* p, Part a) { *p = a; }
SKYBODY_KERNEL Part part_set(float a) { return a; }
SKYBODY_KERNEL Part part_add(Part a, Part b) { return a + b; }
SKYBODY_KERNEL Part part_sub(Part a, Part b) { return a - b; }
SKYBODY_KERNEL Part part_mul(Part a, Part b) { return a * b; }
SKYBODY_KERNEL Part part_div(Part a, Part b) { return a / b; }
/// Rounds twice, as on v2.
SKYBODY_KERNEL Part part_fma(Part a, Part b, Part c) { return a * b + c; }
SKYBODY_KERNEL Part part_sqrt(Part a) { return __builtin_sqrtf(a); }
SKYBODY_KERNEL Part part_min(Part a, Part b) { return a < b ? a : b; }
SKYBODY_KERNEL Part part_max(Part a, Part b) { return a > b ? a : b; }
SKYBODY_KERNEL PartMask part_less(Part a, Part b) { return a < b; }
SKYBODY_KERNEL Part part_select(PartMask m, Part a, Part b) { return m ? a : b; }
SKYBODY_KERNEL PartInts part_load(const uint32_t* p) { return static_cast<int32_t>(*p); }
SKYBODY_KERNEL PartInts part_set(int32_t a) { return a; }
/// Sums and shifts wrap around, which is undefined for signed numbers.
SKYBODY_KERNEL PartInts part_add(PartInts a, PartInts b) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) + static_cast<uint32_t>(b));
}
SKYBODY_KERNEL PartInts part_and(PartInts a, PartInts b) { return a & b; }
SKYBODY_KERNEL PartInts part_xor(PartInts a, PartInts b) { return a ^ b; }
template <int N>
SKYBODY_KERNEL PartInts part_left(PartInts a) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) << N);
}
template <int N>
SKYBODY_KERNEL PartInts part_right(PartInts a) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) >> N);
}
SKYBODY_KERNEL PartMask part_negative(PartInts a) { return a < 0; }
SKYBODY_KERNEL Part part_float(PartInts a) { return static_cast<float>(a); }
SKYBODY_KERNEL PartInts part_bits(Part a) { return __builtin_bit_cast(int32_t, a); }
SKYBODY_KERNEL Part part_of_bits(PartInts a) { return __builtin_bit_cast(float, a); }

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
