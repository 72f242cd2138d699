// Kernels: functions that are compiled once for each instruction set, with the same bits in each.
// The sets are listed in isa_sets.h.
//
//   struct Scale {
//     template <int W>  // lanes of a pack of doubles
//     static SKYBODY_INLINE void run(int count, double* values);
//   };
//   kernel<Scale>(best_isa())(count, values);
#pragma once

#include <utility>

#include "core/base/isa.h"
#include "core/base/kernel_target.h"

namespace skybody {

namespace detail {
template <int kNone, int... kLanes>
using WidthsBehind = std::integer_sequence<int, kLanes...>;
}  // namespace detail

/// Lanes of a pack of doubles on each instruction set, in the order of Isa.
#define SKYBODY_ROW(NAME, LANES, TARGET) , LANES
using PackWidths = detail::WidthsBehind<0 SKYBODY_ISAS(SKYBODY_ROW)>;
#undef SKYBODY_ROW

namespace detail {

template <class Body, class Function>
struct Kernel;

/// Body::run<W> with all that it inlines, compiled for each instruction set.
template <class Body, class Result, class... Args>
struct Kernel<Body, Result(Args...)> {
#define SKYBODY_ROW(NAME, LANES, TARGET) \
  SKYBODY_KERNEL(TARGET)                 \
  static Result NAME(Args... args) { return Body::template run<LANES>(args...); }
  SKYBODY_ISAS(SKYBODY_ROW)
#undef SKYBODY_ROW
#define SKYBODY_ROW(NAME, LANES, TARGET) &NAME,
  static constexpr Result (*kTable[])(Args...) = {SKYBODY_ISAS(SKYBODY_ROW)};
#undef SKYBODY_ROW
};

}  // namespace detail

/// The function that `Body::run` is compiled to for an instruction set.
/// @param isa  that the processor has, such as best_isa()
template <class Body>
constexpr auto* kernel(Isa isa) {
  return detail::Kernel<Body, decltype(Body::template run<2>)>::kTable[static_cast<int>(isa)];
}

}  // namespace skybody
