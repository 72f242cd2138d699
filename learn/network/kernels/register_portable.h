// One float per part; the compiler vectorizes loops over sixteen parts by itself.
#pragma once

#include "learn/network/kernels/kernel_set.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

using Register = float;
using RegisterInts = int32_t;
using RegisterMask = bool;
inline constexpr int kRegisterLanes = 1;
inline constexpr int kTileVectors = 1;
inline constexpr int kTileRows = 2;

SKYBODY_KERNEL Register register_load(const float* p) { return *p; }
SKYBODY_KERNEL void register_store(float* p, Register a) { *p = a; }
SKYBODY_KERNEL Register register_set(float a) { return a; }
SKYBODY_KERNEL Register register_add(Register a, Register b) { return a + b; }
SKYBODY_KERNEL Register register_sub(Register a, Register b) { return a - b; }
SKYBODY_KERNEL Register register_mul(Register a, Register b) { return a * b; }
SKYBODY_KERNEL Register register_div(Register a, Register b) { return a / b; }
/// Rounds twice, as on v2.
SKYBODY_KERNEL Register register_fma(Register a, Register b, Register c) { return a * b + c; }
SKYBODY_KERNEL Register register_sqrt(Register a) { return __builtin_sqrtf(a); }
SKYBODY_KERNEL Register register_min(Register a, Register b) { return a < b ? a : b; }
SKYBODY_KERNEL Register register_max(Register a, Register b) { return a > b ? a : b; }
SKYBODY_KERNEL RegisterMask register_less(Register a, Register b) { return a < b; }
SKYBODY_KERNEL Register register_select(RegisterMask m, Register a, Register b) {
  return m ? a : b;
}
SKYBODY_KERNEL RegisterInts register_load(const uint32_t* p) { return static_cast<int32_t>(*p); }
SKYBODY_KERNEL RegisterInts register_set(int32_t a) { return a; }
/// Sums and shifts wrap around, which is undefined for signed numbers.
SKYBODY_KERNEL RegisterInts register_add(RegisterInts a, RegisterInts b) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) + static_cast<uint32_t>(b));
}
SKYBODY_KERNEL RegisterInts register_and(RegisterInts a, RegisterInts b) { return a & b; }
SKYBODY_KERNEL RegisterInts register_xor(RegisterInts a, RegisterInts b) { return a ^ b; }
template <int N>
SKYBODY_KERNEL RegisterInts register_left(RegisterInts a) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) << N);
}
template <int N>
SKYBODY_KERNEL RegisterInts register_right(RegisterInts a) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) >> N);
}
SKYBODY_KERNEL RegisterMask register_negative(RegisterInts a) { return a < 0; }
SKYBODY_KERNEL Register register_float(RegisterInts a) { return static_cast<float>(a); }
SKYBODY_KERNEL RegisterInts register_bits(Register a) { return __builtin_bit_cast(int32_t, a); }
SKYBODY_KERNEL Register register_of_bits(RegisterInts a) { return __builtin_bit_cast(float, a); }

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
