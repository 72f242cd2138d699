// Blocks of eight lanes: the unit of work of row kernels.
#pragma once

#include <bit>
#include <cstdint>

#include "core/base/simd/lanes.h"

namespace skybody {

inline constexpr int kOctet = 8;

/// The lanes of a mask that lie in complete blocks of eight (lanes 0 to 7, 8 to 15, ...).
inline std::uint32_t whole_octets(std::uint32_t mask) {
  std::uint32_t all = mask & (mask >> 4);
  all &= all >> 2;
  all &= all >> 1;
  return (all & 0x01010101u) * 0xffu;
}

/// Calls f(first lane) for every block of eight lanes in a mask of complete blocks.
template <class F>
SKYBODY_INLINE void each_octet(std::uint32_t mask, F&& f) {
  for (int first = 0; mask != 0; first += kOctet, mask >>= kOctet) {
    if ((mask & 1u) != 0) f(first);
  }
}

/// Calls f(lane) for every lane of a mask.
template <class F>
SKYBODY_INLINE void each_lane(std::uint32_t mask, F&& f) {
  for (; mask != 0; mask &= mask - 1) f(std::countr_zero(mask));
}

/// A mask of the first `count` lanes, 0 <= count <= 32.
inline std::uint32_t first_lanes(int count) {
  return static_cast<std::uint32_t>((std::uint64_t{1} << count) - 1);
}

}  // namespace skybody
