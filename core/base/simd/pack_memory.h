// Memory access of packs, lanes and bits: loads, stores, single lanes, casts between reals and
// words. Include core/base/simd/pack.h, which includes this file.
#pragma once

#include "core/base/simd/pack.h"

namespace skybody {

/// The mask whose lane i is bit i of `bits` (double: bit 0).
template <class Real>
SKYBODY_INLINE MaskOf<Real> mask_from_bits(std::uint32_t bits) {
  constexpr int kLanes = kLanesOf<Real>;
  if constexpr (kLanes == 1) {
    return (bits & 1u) != 0;
  } else {
    using Native = lanes::Native<kLanes>;
    const WordPack<kLanes> all(bits);
    const typename Native::Words v = typename Native::Words{} - ((all.v >> Native::kIota) & 1u);
    return Mask<kLanes>(reinterpret_cast<typename Native::Ints>(v));
  }
}

/// The 64 bits of each lane.
SKYBODY_INLINE std::uint64_t bit_cast_word(double x) { return lanes::copy_bits<std::uint64_t>(x); }
template <int W>
SKYBODY_INLINE WordPack<W> bit_cast_word(const Pack<W>& x) {
  return WordPack<W>(reinterpret_cast<typename lanes::Native<W>::Words>(x.v));
}
/// The doubles with the given bits.
SKYBODY_INLINE double bit_cast_real(std::uint64_t w) { return lanes::copy_bits<double>(w); }
template <int W>
SKYBODY_INLINE Pack<W> bit_cast_real(const WordPack<W>& w) {
  return Pack<W>(reinterpret_cast<typename lanes::Native<W>::Reals>(w.v));
}

/// Like select(), computed on words. g++ 12 splits select() by lane in two cases: several
/// selections by one combined mask, and selections between constants (docs/stepping.md).
SKYBODY_INLINE double choose(bool mask, double a, double b) { return mask ? a : b; }
template <int W>
SKYBODY_INLINE Pack<W> choose(const Mask<W>& mask, const Pack<W>& a, const Pack<W>& b) {
  return bit_cast_real(select(mask, bit_cast_word(a), bit_cast_word(b)));
}

namespace detail {
constexpr double kTwo52 = 4503599627370496.0;                // 2^52
constexpr std::uint64_t kTwo52Bits = 0x4330000000000000ull;  // its bits
constexpr double kRoundMagic = 6755399441055744.0;           // 1.5 * 2^52
constexpr std::uint64_t kSignBit = 0x8000000000000000ull;
constexpr std::uint64_t kFractionBits = 0x000fffffffffffffull;
}  // namespace detail

/// Words below 2^52 as doubles, exactly. Larger words give an unspecified value.
SKYBODY_INLINE double to_real(std::uint64_t w) {
  return bit_cast_real(w | detail::kTwo52Bits) - detail::kTwo52;
}
template <int W>
SKYBODY_INLINE Pack<W> to_real(const WordPack<W>& w) {
  return bit_cast_real(w | detail::kTwo52Bits) - detail::kTwo52;
}

/// Whole numbers 0 <= x < 2^52 as words, exactly. Other values give an unspecified word.
SKYBODY_INLINE std::uint64_t to_word(double x) {
  return bit_cast_word(x + detail::kTwo52) & detail::kFractionBits;
}
template <int W>
SKYBODY_INLINE WordPack<W> to_word(const Pack<W>& x) {
  return bit_cast_word(x + detail::kTwo52) & detail::kFractionBits;
}

/// Reads kLanesOf<Real> consecutive doubles. The alignment of a double suffices.
template <class Real>
SKYBODY_INLINE Real load_lanes(const double* p) {
  if constexpr (kLanesOf<Real> == 1) {
    return *p;
  } else {
    typename Real::Native v;
    std::memcpy(&v, p, sizeof(v));
    return Real(v);
  }
}

/// Reads kLanesOf<Real> scattered doubles: lane i is p[places[i]].
template <class Real>
SKYBODY_INLINE Real gather_lanes(const double* p, const std::uint8_t* places) {
  using Native = typename Real::Native;
  // Built in registers: a vector load after scalar stores to the same memory waits for them.
  if constexpr (kLanesOf<Real> == 2) {
    return Real(Native{p[places[0]], p[places[1]]});
  } else if constexpr (kLanesOf<Real> == 4) {
    return Real(Native{p[places[0]], p[places[1]], p[places[2]], p[places[3]]});
  } else {
    return Real(Native{p[places[0]], p[places[1]], p[places[2]], p[places[3]], p[places[4]],
                       p[places[5]], p[places[6]], p[places[7]]});
  }
}

/// Reads kLanesOf<Real> consecutive words.
template <class Real>
SKYBODY_INLINE Word<Real> load_words(const std::uint64_t* p) {
  if constexpr (kLanesOf<Real> == 1) {
    return *p;
  } else {
    typename Word<Real>::Native v;
    std::memcpy(&v, p, sizeof(v));
    return Word<Real>(v);
  }
}

/// Writes the lanes to consecutive doubles or words.
SKYBODY_INLINE void store_lanes(double* p, double x) { *p = x; }
template <int W>
SKYBODY_INLINE void store_lanes(double* p, const Pack<W>& x) {
  std::memcpy(p, &x.v, sizeof(x.v));
}
SKYBODY_INLINE void store_words(std::uint64_t* p, std::uint64_t w) { *p = w; }
template <int W>
SKYBODY_INLINE void store_words(std::uint64_t* p, const WordPack<W>& w) {
  std::memcpy(p, &w.v, sizeof(w.v));
}

/// Writes the lanes selected by the mask; the other lanes keep their values. All W places are read
/// and written (a blend), so only one thread may access them.
SKYBODY_INLINE void store_lanes(double* p, double x, bool mask) { *p = mask ? x : *p; }
// On words: g++ 12 merges the condition of a selection in `x` with this mask, and splits the result
// by lane.
template <int W>
SKYBODY_INLINE void store_lanes(double* p, const Pack<W>& x, const Mask<W>& mask) {
  store_lanes(p, choose(mask, x, load_lanes<Pack<W>>(p)));
}
SKYBODY_INLINE void store_words(std::uint64_t* p, std::uint64_t w, bool mask) {
  *p = mask ? w : *p;
}
template <int W>
SKYBODY_INLINE void store_words(std::uint64_t* p, const WordPack<W>& w, const Mask<W>& mask) {
  store_words(p, select(mask, w, load_words<Pack<W>>(p)));
}

/// Lane i, 0 <= i < kLanesOf<Real>.
SKYBODY_INLINE double lane(double x, int) { return x; }
SKYBODY_INLINE std::uint64_t lane(std::uint64_t w, int) { return w; }
SKYBODY_INLINE bool lane(bool mask, int) { return mask; }
template <int W>
SKYBODY_INLINE double lane(const Pack<W>& x, int i) {
  return x.v[i];
}
template <int W>
SKYBODY_INLINE std::uint64_t lane(const WordPack<W>& w, int i) {
  return w.v[i];
}
template <int W>
SKYBODY_INLINE bool lane(const Mask<W>& mask, int i) {
  return mask.v[i] != 0;
}

/// Replaces lane i, 0 <= i < kLanesOf<Real>.
SKYBODY_INLINE void set_lane(double& x, int, double value) { x = value; }
SKYBODY_INLINE void set_lane(std::uint64_t& w, int, std::uint64_t value) { w = value; }
template <int W>
SKYBODY_INLINE void set_lane(Pack<W>& x, int i, double value) {
  x.v[i] = value;
}
template <int W>
SKYBODY_INLINE void set_lane(WordPack<W>& w, int i, std::uint64_t value) {
  w.v[i] = value;
}

}  // namespace skybody
