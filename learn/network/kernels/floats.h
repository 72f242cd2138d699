// Sixteen floats in one zmm, two ymm, four xmm, or an array. Every operation rounds each lane by
// IEEE 754, so the bits are the same on all sets, except that v2 and `portable` have no fused
// multiply-add.
#pragma once

#include "learn/network/kernels/kernel_set.h"

#if defined(__AVX512F__)
#include "learn/network/kernels/part_v4.h"
#elif defined(__AVX2__)
#include "learn/network/kernels/part_v3.h"
#elif SKYBODY_HAS_LEVELS
#include "learn/network/kernels/part_v2.h"
#else
#include "learn/network/kernels/part_portable.h"
#endif

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

inline constexpr int kLanes = 16;
inline constexpr int kParts = kLanes / kPartLanes;

struct Floats {
  Part part[kParts];
};
/// Signed, 32 bits, with wrap-around.
struct Ints {
  PartInts part[kParts];
};
struct Mask {
  PartMask part[kParts];
};

#define SKYBODY_EACH_PART(TYPE, EXPRESSION)                                                  \
  TYPE result;                                                                               \
  _Pragma("GCC unroll 16") for (int i = 0; i < kParts; ++i) { result.part[i] = EXPRESSION; } \
  return result

SKYBODY_KERNEL Floats load(const float* p) {
  SKYBODY_EACH_PART(Floats, part_load(p + i * kPartLanes));
}
SKYBODY_KERNEL void store(float* p, const Floats& a) {
#pragma GCC unroll 16
  for (int i = 0; i < kParts; ++i) part_store(p + i * kPartLanes, a.part[i]);
}
SKYBODY_KERNEL Floats floats(float a) { SKYBODY_EACH_PART(Floats, part_set(a)); }
SKYBODY_KERNEL Floats operator+(const Floats& a, const Floats& b) {
  SKYBODY_EACH_PART(Floats, part_add(a.part[i], b.part[i]));
}
SKYBODY_KERNEL Floats operator-(const Floats& a, const Floats& b) {
  SKYBODY_EACH_PART(Floats, part_sub(a.part[i], b.part[i]));
}
SKYBODY_KERNEL Floats operator*(const Floats& a, const Floats& b) {
  SKYBODY_EACH_PART(Floats, part_mul(a.part[i], b.part[i]));
}
SKYBODY_KERNEL Floats operator/(const Floats& a, const Floats& b) {
  SKYBODY_EACH_PART(Floats, part_div(a.part[i], b.part[i]));
}
/// a b + c, rounded once if the set has fused multiply-add.
SKYBODY_KERNEL Floats fma(const Floats& a, const Floats& b, const Floats& c) {
  SKYBODY_EACH_PART(Floats, part_fma(a.part[i], b.part[i], c.part[i]));
}
SKYBODY_KERNEL Floats sqrt(const Floats& a) { SKYBODY_EACH_PART(Floats, part_sqrt(a.part[i])); }
/// Returns b if one is NaN.
SKYBODY_KERNEL Floats min(const Floats& a, const Floats& b) {
  SKYBODY_EACH_PART(Floats, part_min(a.part[i], b.part[i]));
}
SKYBODY_KERNEL Floats max(const Floats& a, const Floats& b) {
  SKYBODY_EACH_PART(Floats, part_max(a.part[i], b.part[i]));
}
SKYBODY_KERNEL Mask operator<(const Floats& a, const Floats& b) {
  SKYBODY_EACH_PART(Mask, part_less(a.part[i], b.part[i]));
}
SKYBODY_KERNEL Floats select(const Mask& m, const Floats& a, const Floats& b) {
  SKYBODY_EACH_PART(Floats, part_select(m.part[i], a.part[i], b.part[i]));
}

SKYBODY_KERNEL Ints load(const uint32_t* p) {
  SKYBODY_EACH_PART(Ints, part_load(p + i * kPartLanes));
}
SKYBODY_KERNEL Ints ints(int32_t a) { SKYBODY_EACH_PART(Ints, part_set(a)); }
SKYBODY_KERNEL Ints operator+(const Ints& a, const Ints& b) {
  SKYBODY_EACH_PART(Ints, part_add(a.part[i], b.part[i]));
}
SKYBODY_KERNEL Ints operator&(const Ints& a, const Ints& b) {
  SKYBODY_EACH_PART(Ints, part_and(a.part[i], b.part[i]));
}
SKYBODY_KERNEL Ints operator^(const Ints& a, const Ints& b) {
  SKYBODY_EACH_PART(Ints, part_xor(a.part[i], b.part[i]));
}
template <int N>
SKYBODY_KERNEL Ints left(const Ints& a) {
  SKYBODY_EACH_PART(Ints, part_left<N>(a.part[i]));
}
/// Logical shift: fills with zeros.
template <int N>
SKYBODY_KERNEL Ints right(const Ints& a) {
  SKYBODY_EACH_PART(Ints, part_right<N>(a.part[i]));
}
SKYBODY_KERNEL Mask is_negative(const Ints& a) {
  SKYBODY_EACH_PART(Mask, part_negative(a.part[i]));
}
/// Rounds to nearest.
SKYBODY_KERNEL Floats to_floats(const Ints& a) { SKYBODY_EACH_PART(Floats, part_float(a.part[i])); }
SKYBODY_KERNEL Ints bits(const Floats& a) { SKYBODY_EACH_PART(Ints, part_bits(a.part[i])); }
SKYBODY_KERNEL Floats of_bits(const Ints& a) { SKYBODY_EACH_PART(Floats, part_of_bits(a.part[i])); }
#undef SKYBODY_EACH_PART

/// a(0) + x (a(1) + x (... a(n))), by Horner's rule.
template <int N>
SKYBODY_KERNEL Floats polynomial(const float (&a)[N], const Floats& x) {
  Floats sum = floats(a[N - 1]);
#pragma GCC unroll 16
  for (int k = N - 2; k >= 0; --k) sum = fma(sum, x, floats(a[k]));
  return sum;
}

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
