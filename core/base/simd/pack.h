// Packs: one quantity of W environments, computed together. Code that is a template on `Real`
// compiles for double and for Pack<W> and gives the same bits in each lane.
//
// The interface for authors: arithmetic and comparisons as for double; `select(mask, a, b)` instead
// of `if`; `any`, `all`, `none` of a mask. Comparisons return MaskOf<Real>: bool, or Mask<W>.
// Every operation is one IEEE 754 double operation per lane, in the order written. Only the payload
// and sign of a NaN may differ between double and packs.
#pragma once

#include <type_traits>

#include "core/base/simd/lanes.h"

namespace skybody {

// Broadcasts always build a vector of another element type than the member and cast it. g++ 12
// splits a direct assignment into one store per lane if the file's own instruction set lacks such
// vectors, and does not merge the stores again in functions compiled for a set that has them.
template <int W>
struct Pack;
template <int W>
struct WordPack;

namespace lanes {

/// Keeps the result of a comparison, lanes of 0 or -1, a vector of integers. Otherwise g++ 14 makes
/// it a vector of truth values, and ends with an internal error (in do_store_flag) if a plugin uses
/// a result of 8 lanes after a branch. Without optimisation and with AddressSanitizer, functions
/// are not inlined into those with registers of 8 lanes.
template <int W>
SKYBODY_INLINE void settle([[maybe_unused]] typename Native<W>::Ints& truths) {
#if defined(SKYBODY_SETTLES_COMPARISONS) && defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__)
  if constexpr (W == 8) asm("" : "+v"(truths));
#endif
}

}  // namespace lanes

/// The result of a comparison in each of W lanes: all bits of a lane are set, or none.
template <int W>
struct Mask {
  using Native = typename lanes::Native<W>::Ints;
  Native v;

  Mask() = default;
  // In some compilers a comparison has another type of the same size: cast it to Native.
  SKYBODY_INLINE explicit Mask(const Native& native) : v(native) {}
  using Words = typename lanes::Native<W>::Words;
  SKYBODY_INLINE explicit Mask(const Words& words) : v(reinterpret_cast<Native>(words)) {}
  SKYBODY_INLINE Words words() const { return reinterpret_cast<Words>(v); }
  /// The same truth value in every lane.
  SKYBODY_INLINE Mask(bool all_lanes) {
    const Words all = (std::uint64_t{0} - static_cast<std::uint64_t>(all_lanes)) + Words{};
    v = reinterpret_cast<Native>(all);
  }

  /// Never compiles, and its message contains the remedy: lanes may disagree on a branch.
  template <class Bool = bool, class = std::enable_if_t<std::is_same<Bool, bool>::value>>
  explicit operator Bool() const {
    static_assert(!std::is_same<Bool, bool>::value,
                  "a branch on lanes: use skybody::select(mask, a, b) instead of if");
    return false;
  }

  // On words: g++ 12 merges two comparisons into one of a type that it then splits by lane.
  friend SKYBODY_INLINE Mask operator&(const Mask& a, const Mask& b) {
    return Mask(a.words() & b.words());
  }
  friend SKYBODY_INLINE Mask operator|(const Mask& a, const Mask& b) {
    return Mask(a.words() | b.words());
  }
  friend SKYBODY_INLINE Mask operator^(const Mask& a, const Mask& b) {
    return Mask(a.words() ^ b.words());
  }
  friend SKYBODY_INLINE Mask operator!(const Mask& a) { return Mask(~a.words()); }
  /// Like & and |: both sides are evaluated. They allow conditions written for double to compile.
  friend SKYBODY_INLINE Mask operator&&(const Mask& a, const Mask& b) { return a & b; }
  friend SKYBODY_INLINE Mask operator||(const Mask& a, const Mask& b) { return a | b; }
  SKYBODY_INLINE Mask& operator&=(const Mask& b) { return *this = *this & b; }
  SKYBODY_INLINE Mask& operator|=(const Mask& b) { return *this = *this | b; }

  /// Per lane: a where the mask is set, else b.
  friend SKYBODY_INLINE Pack<W> select(const Mask& mask, const Pack<W>& a, const Pack<W>& b) {
    return Pack<W>(mask.v ? a.v : b.v);
  }
  friend SKYBODY_INLINE WordPack<W> select(const Mask& mask, const WordPack<W>& a,
                                           const WordPack<W>& b) {
    const Words m = mask.words();
    return WordPack<W>((a.v & m) | (b.v & ~m));
  }
  friend SKYBODY_INLINE Mask select(const Mask& mask, const Mask& a, const Mask& b) {
    return (a & mask) | (b & !mask);
  }
};

/// W unsigned 64-bit words; arithmetic is modulo 2^64.
template <int W>
struct WordPack {
  using Native = typename lanes::Native<W>::Words;
  Native v;

  WordPack() = default;
  SKYBODY_INLINE explicit WordPack(const Native& native) : v(native) {}
  /// The same word in every lane.
  template <class Integer, class = std::enable_if_t<std::is_integral<Integer>::value>>
  SKYBODY_INLINE WordPack(Integer all_lanes) {
    using Ints = typename lanes::Native<W>::Ints;
    const Ints all = static_cast<std::int64_t>(all_lanes) + Ints{};
    v = reinterpret_cast<Native>(all);
  }

#define SKYBODY_WORD_OPERATOR(op)                                                    \
  friend SKYBODY_INLINE WordPack operator op(const WordPack& a, const WordPack& b) { \
    return WordPack(a.v op b.v);                                                     \
  }                                                                                  \
  SKYBODY_INLINE WordPack& operator op##=(const WordPack& b) { return *this = *this op b; }
  SKYBODY_WORD_OPERATOR(+)
  SKYBODY_WORD_OPERATOR(-)
  SKYBODY_WORD_OPERATOR(*)
  SKYBODY_WORD_OPERATOR(&)
  SKYBODY_WORD_OPERATOR(|)
  SKYBODY_WORD_OPERATOR(^)
#undef SKYBODY_WORD_OPERATOR
  friend SKYBODY_INLINE WordPack operator~(const WordPack& a) { return WordPack(~a.v); }
  /// Shifts every lane by the same count, 0 <= count < 64.
  friend SKYBODY_INLINE WordPack operator<<(const WordPack& a, int n) { return WordPack(a.v << n); }
  friend SKYBODY_INLINE WordPack operator>>(const WordPack& a, int n) { return WordPack(a.v >> n); }

#define SKYBODY_WORD_COMPARISON(op)                                                 \
  friend SKYBODY_INLINE Mask<W> operator op(const WordPack& a, const WordPack& b) { \
    auto truths = reinterpret_cast<typename Mask<W>::Native>(a.v op b.v);           \
    lanes::settle<W>(truths);                                                       \
    return Mask<W>(truths);                                                         \
  }
  SKYBODY_WORD_COMPARISON(==)
  SKYBODY_WORD_COMPARISON(!=)
  SKYBODY_WORD_COMPARISON(<)
  SKYBODY_WORD_COMPARISON(>)
  SKYBODY_WORD_COMPARISON(<=)
  SKYBODY_WORD_COMPARISON(>=)
#undef SKYBODY_WORD_COMPARISON
};

/// W doubles, one per environment of a lane group.
template <int W>
struct Pack {
  using Native = typename lanes::Native<W>::Reals;
  Native v;

  Pack() = default;
  SKYBODY_INLINE explicit Pack(const Native& native) : v(native) {}
  /// The same value in every lane.
  SKYBODY_INLINE Pack(double all_lanes) {
    using Words = typename lanes::Native<W>::Words;
    const Words all = lanes::copy_bits<std::uint64_t>(all_lanes) + Words{};
    v = reinterpret_cast<Native>(all);
  }

#define SKYBODY_REAL_OPERATOR(op)                                        \
  friend SKYBODY_INLINE Pack operator op(const Pack& a, const Pack& b) { \
    return Pack(a.v op b.v);                                             \
  }                                                                      \
  SKYBODY_INLINE Pack& operator op##=(const Pack& b) { return *this = *this op b; }
  SKYBODY_REAL_OPERATOR(+)
  SKYBODY_REAL_OPERATOR(-)
  SKYBODY_REAL_OPERATOR(*)
  SKYBODY_REAL_OPERATOR(/)
#undef SKYBODY_REAL_OPERATOR
  friend SKYBODY_INLINE Pack operator-(const Pack& a) { return Pack(-a.v); }
  friend SKYBODY_INLINE Pack operator+(const Pack& a) { return a; }

#define SKYBODY_REAL_COMPARISON(op)                                         \
  friend SKYBODY_INLINE Mask<W> operator op(const Pack& a, const Pack& b) { \
    auto truths = reinterpret_cast<typename Mask<W>::Native>(a.v op b.v);   \
    lanes::settle<W>(truths);                                               \
    return Mask<W>(truths);                                                 \
  }
  SKYBODY_REAL_COMPARISON(==)
  SKYBODY_REAL_COMPARISON(!=)
  SKYBODY_REAL_COMPARISON(<)
  SKYBODY_REAL_COMPARISON(>)
  SKYBODY_REAL_COMPARISON(<=)
  SKYBODY_REAL_COMPARISON(>=)
#undef SKYBODY_REAL_COMPARISON
};

/// The types of a Real: its mask and its word; and its number of lanes.
template <class Real>
struct RealTraits;
template <>
struct RealTraits<double> {
  using Mask = bool;
  using Word = std::uint64_t;
  static constexpr int kLanes = 1;
};
template <int W>
struct RealTraits<Pack<W>> {
  using Mask = skybody::Mask<W>;
  using Word = WordPack<W>;
  static constexpr int kLanes = W;
};

/// bool for double, Mask<W> for Pack<W>.
template <class Real>
using MaskOf = typename RealTraits<Real>::Mask;
/// std::uint64_t for double, WordPack<W> for Pack<W>.
template <class Real>
using Word = typename RealTraits<Real>::Word;
/// 1 for double, W for Pack<W>.
template <class Real>
constexpr int kLanesOf = RealTraits<Real>::kLanes;

SKYBODY_INLINE double select(bool mask, double a, double b) { return mask ? a : b; }
SKYBODY_INLINE std::uint64_t select(bool mask, std::uint64_t a, std::uint64_t b) {
  return mask ? a : b;
}
SKYBODY_INLINE bool select(bool mask, bool a, bool b) { return mask ? a : b; }

/// Logical operators with the same syntax for bool and Mask; all operands are evaluated.
SKYBODY_INLINE bool logical_and(bool a, bool b) { return a & b; }
SKYBODY_INLINE bool logical_or(bool a, bool b) { return a | b; }
SKYBODY_INLINE bool logical_not(bool a) { return !a; }
template <int W>
SKYBODY_INLINE Mask<W> logical_and(const Mask<W>& a, const Mask<W>& b) {
  return a & b;
}
template <int W>
SKYBODY_INLINE Mask<W> logical_or(const Mask<W>& a, const Mask<W>& b) {
  return a | b;
}
template <int W>
SKYBODY_INLINE Mask<W> logical_not(const Mask<W>& a) {
  return !a;
}

/// Bit i of the result is lane i of the mask.
SKYBODY_INLINE std::uint32_t bits_from_mask(bool mask) { return mask; }
template <int W>
SKYBODY_INLINE std::uint32_t bits_from_mask(const Mask<W>& mask) {
  return lanes::sign_bits(reinterpret_cast<typename lanes::Native<W>::Reals>(mask.v));
}

SKYBODY_INLINE bool any(bool mask) { return mask; }
SKYBODY_INLINE bool all(bool mask) { return mask; }
SKYBODY_INLINE bool none(bool mask) { return !mask; }
/// Whether at least one lane is set.
template <int W>
SKYBODY_INLINE bool any(const Mask<W>& mask) {
  return lanes::any_sign(mask.words());
}
/// Whether every lane is set.
template <int W>
SKYBODY_INLINE bool all(const Mask<W>& mask) {
  return lanes::all_signs(mask.words());
}
/// Whether no lane is set.
template <int W>
SKYBODY_INLINE bool none(const Mask<W>& mask) {
  return !lanes::any_sign(mask.words());
}

}  // namespace skybody

#include "core/base/simd/pack_memory.h"  // IWYU pragma: export
