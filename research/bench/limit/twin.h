// Two packs as one: every operation is done on both, one after the other. A step is a chain of some
// hundred operations, each of which waits for the previous one. Two independent chains keep the
// processor busy during these waits. The same bits as each pack by itself.
#pragma once

#include "research/bench/limit/lane_choice.h"

namespace skybody::bench::limit {

/// The mask of each lane of a Twin.
template <class R>
struct TwinMask {
  MaskOf<R> a, b;
};

/// Lanes of `a`, then those of `b`.
template <class R>
struct Twin {
  R a, b;

  Twin() = default;
  SKYBODY_INLINE Twin(const R& first, const R& second) : a(first), b(second) {}
  /// The same value in every lane.
  SKYBODY_INLINE Twin(double all) : a(all), b(all) {}

#define SKYBODY_TWIN_OPERATOR(op)                                        \
  friend SKYBODY_INLINE Twin operator op(const Twin& x, const Twin& y) { \
    return {x.a op y.a, x.b op y.b};                                     \
  }                                                                      \
  SKYBODY_INLINE Twin& operator op##=(const Twin& y) { return *this = *this op y; }
  SKYBODY_TWIN_OPERATOR(+)
  SKYBODY_TWIN_OPERATOR(-)
  SKYBODY_TWIN_OPERATOR(*)
  SKYBODY_TWIN_OPERATOR(/)
#undef SKYBODY_TWIN_OPERATOR
  friend SKYBODY_INLINE Twin operator-(const Twin& x) { return {-x.a, -x.b}; }

#define SKYBODY_TWIN_COMPARISON(op)                                             \
  friend SKYBODY_INLINE TwinMask<R> operator op(const Twin& x, const Twin& y) { \
    return {x.a op y.a, x.b op y.b};                                            \
  }
  SKYBODY_TWIN_COMPARISON(<)
  SKYBODY_TWIN_COMPARISON(>)
  SKYBODY_TWIN_COMPARISON(<=)
  SKYBODY_TWIN_COMPARISON(>=)
#undef SKYBODY_TWIN_COMPARISON
};

template <class R>
SKYBODY_INLINE Twin<R> pick(const TwinMask<R>& mask, const Twin<R>& x, const Twin<R>& y) {
  return {pick(mask.a, x.a, y.a), pick(mask.b, x.b, y.b)};
}
template <class R>
SKYBODY_INLINE Twin<R> larger(const Twin<R>& x, const Twin<R>& y) {
  return {larger(x.a, y.a), larger(x.b, y.b)};
}
template <class R>
SKYBODY_INLINE Twin<R> smaller(const Twin<R>& x, const Twin<R>& y) {
  return {smaller(x.a, y.a), smaller(x.b, y.b)};
}
template <class R>
SKYBODY_INLINE Twin<R> magnitude(const Twin<R>& x) {
  return {magnitude(x.a), magnitude(x.b)};
}
template <class R>
SKYBODY_INLINE Twin<R> with_sign(const Twin<R>& x, const Twin<R>& sign) {
  return {with_sign(x.a, sign.a), with_sign(x.b, sign.b)};
}
template <class R>
SKYBODY_INLINE Twin<R> full_atan2(const Twin<R>& y, const Twin<R>& x) {
  return {full_atan2(y.a, x.a), full_atan2(y.b, x.b)};
}
template <class R>
SKYBODY_INLINE Twin<R> wrapped(const Twin<R>& x) {
  return {wrapped(x.a), wrapped(x.b)};
}
template <class R>
SKYBODY_INLINE Twin<R> root(const Twin<R>& x) {
  return {root(x.a), root(x.b)};
}
template <class R>
SKYBODY_INLINE Twin<R> exponential(const Twin<R>& x) {
  return {exponential(x.a), exponential(x.b)};
}
template <class R>
SKYBODY_INLINE SinCos<Twin<R>> sincos_of(const Twin<R>& x) {
  const SinCos<R> a = sincos_of(x.a), b = sincos_of(x.b);
  return {{a.sin, b.sin}, {a.cos, b.cos}};
}
template <class R>
SKYBODY_INLINE std::uint32_t bits(const TwinMask<R>& mask) {
  return bits(mask.a) | bits(mask.b) << kLanesOf<R>;
}

template <class R>
struct LaneLoads<Twin<R>> {
  static constexpr int kCount = 2 * LaneLoads<R>::kCount;
  static SKYBODY_INLINE Twin<R> load(const double* p) {
    return {LaneLoads<R>::load(p), LaneLoads<R>::load(p + LaneLoads<R>::kCount)};
  }
  static SKYBODY_INLINE void store(double* p, const Twin<R>& x) {
    LaneLoads<R>::store(p, x.a);
    LaneLoads<R>::store(p + LaneLoads<R>::kCount, x.b);
  }
};

}  // namespace skybody::bench::limit
