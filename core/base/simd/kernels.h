// Kernels: functions compiled once per instruction set, with the same bits in each.
// The sets are listed in isa_sets.h.
//
//   struct Scale {
//     template <int W>  // lanes of a pack of doubles
//     static SKYBODY_INLINE void run(int count, double* values);
//   };
//   kernel<Scale>(best_isa())(count, values);
#pragma once

#include <utility>

#include "core/base/simd/isa.h"
#include "core/base/simd/kernel_target.h"

namespace skybody {

namespace detail {
template <int kNone, int... kLanes>
using WidthsBehind = std::integer_sequence<int, kLanes...>;
}  // namespace detail

/// Lanes of a pack of doubles in each instruction set, in the order of Isa.
#define SKYBODY_ROW(NAME, LANES, TARGET) , LANES
using PackWidths = detail::WidthsBehind<0 SKYBODY_ISAS(SKYBODY_ROW)>;
#undef SKYBODY_ROW

namespace detail {

template <class Body, class Function>
struct Kernel;

/// Body::run<W> with all inlined functions, compiled for each instruction set.
template <class Body, class Result, class... Args>
struct Kernel<Body, Result(Args...)> {
#define SKYBODY_ROW(NAME, LANES, TARGET) \
  SKYBODY_KERNEL(TARGET)                 \
  static Result NAME(Args... args) { return Body::template run<LANES>(args...); }
  SKYBODY_ISAS(SKYBODY_ROW)
#undef SKYBODY_ROW
  using Pointer = Result (*)(Args...);
  template <Isa kIsa>
  static constexpr Pointer of() {
#define SKYBODY_ROW(NAME, LANES, TARGET) \
  if constexpr (kIsa == Isa::NAME && SKYBODY_BUILDS_##NAME != 0) return &NAME;
    SKYBODY_ISAS(SKYBODY_ROW)
#undef SKYBODY_ROW
    return nullptr;
  }
#define SKYBODY_ROW(NAME, LANES, TARGET) of<Isa::NAME>(),
  static constexpr Pointer kTable[] = {SKYBODY_ISAS(SKYBODY_ROW)};
#undef SKYBODY_ROW
};

}  // namespace detail

/// `Body::run` compiled for an instruction set, or for the next lower one if the build lacks it.
/// @param isa  a set that the processor supports, such as best_isa()
template <class Body>
constexpr auto* kernel(Isa isa) {
  using Kernels = detail::Kernel<Body, decltype(Body::template run<2>)>;
  int set = static_cast<int>(isa);
  while (Kernels::kTable[set] == nullptr) --set;
  return Kernels::kTable[set];
}

}  // namespace skybody
