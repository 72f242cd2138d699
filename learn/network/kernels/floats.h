// Sixteen floats in one zmm, two ymm, four xmm, or an array. Every operation rounds each lane by
// IEEE 754, so the bits are the same on all sets, except that v2 and `portable` have no fused
// multiply-add.
#pragma once

#include "learn/network/kernels/kernel_set.h"

#if defined(__AVX512F__)
#include "learn/network/kernels/register_v4.h"
#elif defined(__AVX2__)
#include "learn/network/kernels/register_v3.h"
#elif SKYBODY_HAS_LEVELS
#include "learn/network/kernels/register_v2.h"
#else
#include "learn/network/kernels/register_portable.h"
#endif

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

inline constexpr int kLanes = 16;
inline constexpr int kRegisters = kLanes / kRegisterLanes;

struct Floats {
  Register registers[kRegisters];
};
/// Signed, 32 bits, with wrap-around.
struct Ints {
  RegisterInts registers[kRegisters];
};
struct Mask {
  RegisterMask registers[kRegisters];
};

#define SKYBODY_EACH_REGISTER(TYPE, EXPRESSION)                   \
  TYPE result;                                                    \
  _Pragma("GCC unroll 16") for (int i = 0; i < kRegisters; ++i) { \
    result.registers[i] = EXPRESSION;                             \
  }                                                               \
  return result

SKYBODY_KERNEL Floats load(const float* p) {
  SKYBODY_EACH_REGISTER(Floats, register_load(p + i * kRegisterLanes));
}
SKYBODY_KERNEL void store(float* p, const Floats& a) {
#pragma GCC unroll 16
  for (int i = 0; i < kRegisters; ++i) register_store(p + i * kRegisterLanes, a.registers[i]);
}
SKYBODY_KERNEL Floats floats(float a) { SKYBODY_EACH_REGISTER(Floats, register_set(a)); }
SKYBODY_KERNEL Floats operator+(const Floats& a, const Floats& b) {
  SKYBODY_EACH_REGISTER(Floats, register_add(a.registers[i], b.registers[i]));
}
SKYBODY_KERNEL Floats operator-(const Floats& a, const Floats& b) {
  SKYBODY_EACH_REGISTER(Floats, register_sub(a.registers[i], b.registers[i]));
}
SKYBODY_KERNEL Floats operator*(const Floats& a, const Floats& b) {
  SKYBODY_EACH_REGISTER(Floats, register_mul(a.registers[i], b.registers[i]));
}
SKYBODY_KERNEL Floats operator/(const Floats& a, const Floats& b) {
  SKYBODY_EACH_REGISTER(Floats, register_div(a.registers[i], b.registers[i]));
}
/// a b + c, rounded once if the set has fused multiply-add.
SKYBODY_KERNEL Floats fma(const Floats& a, const Floats& b, const Floats& c) {
  SKYBODY_EACH_REGISTER(Floats, register_fma(a.registers[i], b.registers[i], c.registers[i]));
}
SKYBODY_KERNEL Floats sqrt(const Floats& a) {
  SKYBODY_EACH_REGISTER(Floats, register_sqrt(a.registers[i]));
}
/// Returns b if one is NaN.
SKYBODY_KERNEL Floats min(const Floats& a, const Floats& b) {
  SKYBODY_EACH_REGISTER(Floats, register_min(a.registers[i], b.registers[i]));
}
SKYBODY_KERNEL Floats max(const Floats& a, const Floats& b) {
  SKYBODY_EACH_REGISTER(Floats, register_max(a.registers[i], b.registers[i]));
}
SKYBODY_KERNEL Mask operator<(const Floats& a, const Floats& b) {
  SKYBODY_EACH_REGISTER(Mask, register_less(a.registers[i], b.registers[i]));
}
SKYBODY_KERNEL Floats select(const Mask& m, const Floats& a, const Floats& b) {
  SKYBODY_EACH_REGISTER(Floats, register_select(m.registers[i], a.registers[i], b.registers[i]));
}

SKYBODY_KERNEL Ints load(const uint32_t* p) {
  SKYBODY_EACH_REGISTER(Ints, register_load(p + i * kRegisterLanes));
}
SKYBODY_KERNEL Ints ints(int32_t a) { SKYBODY_EACH_REGISTER(Ints, register_set(a)); }
SKYBODY_KERNEL Ints operator+(const Ints& a, const Ints& b) {
  SKYBODY_EACH_REGISTER(Ints, register_add(a.registers[i], b.registers[i]));
}
SKYBODY_KERNEL Ints operator&(const Ints& a, const Ints& b) {
  SKYBODY_EACH_REGISTER(Ints, register_and(a.registers[i], b.registers[i]));
}
SKYBODY_KERNEL Ints operator^(const Ints& a, const Ints& b) {
  SKYBODY_EACH_REGISTER(Ints, register_xor(a.registers[i], b.registers[i]));
}
template <int N>
SKYBODY_KERNEL Ints left(const Ints& a) {
  SKYBODY_EACH_REGISTER(Ints, register_left<N>(a.registers[i]));
}
/// Logical shift: fills with zeros.
template <int N>
SKYBODY_KERNEL Ints right(const Ints& a) {
  SKYBODY_EACH_REGISTER(Ints, register_right<N>(a.registers[i]));
}
SKYBODY_KERNEL Mask is_negative(const Ints& a) {
  SKYBODY_EACH_REGISTER(Mask, register_negative(a.registers[i]));
}
/// Rounds to nearest.
SKYBODY_KERNEL Floats to_floats(const Ints& a) {
  SKYBODY_EACH_REGISTER(Floats, register_float(a.registers[i]));
}
SKYBODY_KERNEL Ints bits(const Floats& a) {
  SKYBODY_EACH_REGISTER(Ints, register_bits(a.registers[i]));
}
SKYBODY_KERNEL Floats of_bits(const Ints& a) {
  SKYBODY_EACH_REGISTER(Floats, register_of_bits(a.registers[i]));
}
#undef SKYBODY_EACH_REGISTER

/// a(0) + x (a(1) + x (... a(n))), by Horner's rule.
template <int N>
SKYBODY_KERNEL Floats polynomial(const float (&a)[N], const Floats& x) {
  Floats sum = floats(a[N - 1]);
#pragma GCC unroll 16
  for (int k = N - 2; k >= 0; --k) sum = fma(sum, x, floats(a[k]));
  return sum;
}

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
