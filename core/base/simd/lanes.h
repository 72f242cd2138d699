// The storage of packs: one native vector of W doubles, or of W signed or unsigned 64-bit words.
// Needs GCC's or Clang's vector extensions. Internal: use core/base/simd/pack.h.
#pragma once

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <cstdint>
#include <cstring>

/// SKYBODY_INLINE before a function, SKYBODY_INLINE_LAMBDA after a lambda's parameters: inlines
/// into every caller at every level of optimisation, so that a pack operation uses the instruction
/// set of its caller (`__attribute__((target(...), flatten))`). That set must contain the file's
/// own -march: compile files with kernel variants for the lowest set. Disabled at -O0 and under
/// AddressSanitizer, where functions of that size take minutes to compile. There all kernels use
/// the file's own instruction set (core/base/simd/kernel_target.h), and calls between them give the
/// same bits.
#if !defined(__OPTIMIZE__) || defined(__SANITIZE_ADDRESS__)
#define SKYBODY_INLINE inline
#define SKYBODY_INLINE_LAMBDA
#else
#define SKYBODY_INLINE inline __attribute__((always_inline))
#define SKYBODY_INLINE_LAMBDA __attribute__((always_inline))
#endif

namespace skybody {
namespace lanes {

/// Native vectors of W lanes, for W = 2, 4 and 8: the widths of the sets in isa_sets.h.
template <int W>
struct Native;

template <>
struct Native<2> {
  typedef double Reals __attribute__((vector_size(16)));
  typedef std::int64_t Ints __attribute__((vector_size(16)));
  typedef std::uint64_t Words __attribute__((vector_size(16)));
  static constexpr Words kIota = {0, 1};
};

template <>
struct Native<4> {
  typedef double Reals __attribute__((vector_size(32)));
  typedef std::int64_t Ints __attribute__((vector_size(32)));
  typedef std::uint64_t Words __attribute__((vector_size(32)));
  static constexpr Words kIota = {0, 1, 2, 3};
};

template <>
struct Native<8> {
  typedef double Reals __attribute__((vector_size(64)));
  typedef std::int64_t Ints __attribute__((vector_size(64)));
  typedef std::uint64_t Words __attribute__((vector_size(64)));
  static constexpr Words kIota = {0, 1, 2, 3, 4, 5, 6, 7};
};

using Reals2 = Native<2>::Reals;
using Reals4 = Native<4>::Reals;
using Reals8 = Native<8>::Reals;

// Results are returned through references: returning a wide vector in a file compiled for a
// narrower set causes -Wpsabi warnings, although no call remains after inlining.
SKYBODY_INLINE void split(const Reals4& v, Reals2& low, Reals2& high) {
  low = __builtin_shufflevector(v, v, 0, 1);
  high = __builtin_shufflevector(v, v, 2, 3);
}
SKYBODY_INLINE void split(const Reals8& v, Reals4& low, Reals4& high) {
  low = __builtin_shufflevector(v, v, 0, 1, 2, 3);
  high = __builtin_shufflevector(v, v, 4, 5, 6, 7);
}

#ifdef __SSE2__
/// Correctly rounded square roots.
SKYBODY_INLINE void sqrt(const Reals2& v, Reals2& root) {
  root = reinterpret_cast<Reals2>(_mm_sqrt_pd(reinterpret_cast<__m128d>(v)));
}
/// Bit i of the result is the sign bit of lane i.
SKYBODY_INLINE std::uint32_t sign_bits(const Reals2& v) {
  return static_cast<std::uint32_t>(_mm_movemask_pd(reinterpret_cast<__m128d>(v)));
}
#else
SKYBODY_INLINE void sqrt(const Reals2& v, Reals2& root) {
  root = Reals2{__builtin_sqrt(v[0]), __builtin_sqrt(v[1])};
}
SKYBODY_INLINE std::uint32_t sign_bits(const Reals2& v) {
  const auto words = reinterpret_cast<Native<2>::Words>(v) >> 63;
  return static_cast<std::uint32_t>(words[0] | words[1] << 1);
}
#endif
// Compilers emit one instruction for each of these if the function's set has it.
SKYBODY_INLINE void sqrt(const Reals4& v, Reals4& root) {
  root = Reals4{__builtin_sqrt(v[0]), __builtin_sqrt(v[1]), __builtin_sqrt(v[2]),
                __builtin_sqrt(v[3])};
}
SKYBODY_INLINE void sqrt(const Reals8& v, Reals8& root) {
  root = Reals8{__builtin_sqrt(v[0]), __builtin_sqrt(v[1]), __builtin_sqrt(v[2]),
                __builtin_sqrt(v[3]), __builtin_sqrt(v[4]), __builtin_sqrt(v[5]),
                __builtin_sqrt(v[6]), __builtin_sqrt(v[7])};
}

SKYBODY_INLINE std::uint32_t sign_bits(const Reals4& v) {
  Reals2 low, high;
  split(v, low, high);
  return sign_bits(low) | sign_bits(high) << 2;
}
/// The highest byte of each lane, in one word: two instructions with v4.
SKYBODY_INLINE std::uint64_t high_bytes(const Native<8>::Words& v) {
  typedef std::uint8_t Bytes __attribute__((vector_size(8)));
  const Bytes bytes = __builtin_convertvector(v >> 56, Bytes);
  std::uint64_t word;
  std::memcpy(&word, &bytes, sizeof(word));
  return word;
}
SKYBODY_INLINE std::uint32_t sign_bits(const Reals8& v) {
  // The sign of lane i is at bit 8 i; the product places all signs next to each other from bit 56.
  const std::uint64_t signs =
      high_bytes(reinterpret_cast<Native<8>::Words>(v)) >> 7 & 0x0101010101010101u;
  return static_cast<std::uint32_t>(signs * 0x0102040810204080u >> 56);
}

/// Whether any lane's sign bit is set, and whether all are: combines halves, then tests once.
SKYBODY_INLINE bool any_sign(const Native<2>::Words& v) {
  return sign_bits(reinterpret_cast<Reals2>(v)) != 0;
}
SKYBODY_INLINE bool all_signs(const Native<2>::Words& v) {
  return sign_bits(reinterpret_cast<Reals2>(v)) == 3;
}
SKYBODY_INLINE bool any_sign(const Native<4>::Words& v) {
  const Native<2>::Words low = __builtin_shufflevector(v, v, 0, 1),
                         high = __builtin_shufflevector(v, v, 2, 3);
  return any_sign(low | high);
}
SKYBODY_INLINE bool all_signs(const Native<4>::Words& v) {
  const Native<2>::Words low = __builtin_shufflevector(v, v, 0, 1),
                         high = __builtin_shufflevector(v, v, 2, 3);
  return all_signs(low & high);
}
SKYBODY_INLINE bool any_sign(const Native<8>::Words& v) {
  return (high_bytes(v) & 0x8080808080808080u) != 0;
}
SKYBODY_INLINE bool all_signs(const Native<8>::Words& v) {
  return (~high_bytes(v) & 0x8080808080808080u) == 0;
}

/// Copies the bits of `from` into a value of type To of the same size, as std::bit_cast does.
template <class To, class From>
SKYBODY_INLINE To copy_bits(const From& from) {
  static_assert(sizeof(To) == sizeof(From), "copy_bits: both types need the same size");
  To to;
  std::memcpy(&to, &from, sizeof(To));
  return to;
}

}  // namespace lanes
}  // namespace skybody
