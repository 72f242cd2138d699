// Standard normals from random words (Box and Muller 1958, both branches), sixteen at a time.
#pragma once

#include "learn/network/kernels/functions.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

/// 2^-32 (word + 1/2), in (0, 1]. Small values keep all their bits, which the tails of the normals
/// need.
SKYBODY_KERNEL Floats uniform(const Ints& word) {
  const Floats high = to_floats(right<16>(word));
  const Floats low = to_floats(word & ints(0xffff));
  return fma(high, floats(65536.0f), low + floats(0.5f)) * floats(0x1p-32f);
}

/// Radius sqrt(-2 log u), at most 6.8.
SKYBODY_KERNEL Floats normal_radius(const Ints& word) {
  return sqrt(floats(-2.0f) * log(uniform(word)));
}

SKYBODY_KERNEL void normals_of_16(const uint32_t* radius, const uint32_t* angle, float* y) {
  const Floats r = normal_radius(load(radius));
  // The upper two bits choose a quadrant, the others an angle in [-pi / 4, pi / 4).
  const Ints turn = load(angle);
  const Floats part = to_floats((turn & ints(0x3fffffff)) + ints(-0x20000000));
  const SmallAngle a = sincos_of_small(part * floats(0x1.921fb6p-30f));
  const Mask swaps = is_negative(left<1>(turn));
  const Ints sign = turn & ints(static_cast<int32_t>(0x80000000u));
  // Quadrant 0: (c, s), 1: (-s, c), 2: (-c, -s), 3: (s, -c).
  const Floats cosine = of_bits(bits(select(swaps, floats(0.0f) - a.sine, a.cosine)) ^ sign);
  const Floats sine = of_bits(bits(select(swaps, a.cosine, a.sine)) ^ sign);
  store(y, r * cosine);
  store(y + kLanes, r * sine);
}

inline void normals(const uint32_t* radius, const uint32_t* angle, float* y, size_t count) {
  for (size_t i = 0; i < count; i += kLanes) normals_of_16(radius + i, angle + i, y + 2 * i);
}

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
