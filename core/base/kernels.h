// Kernels: functions that are compiled once for each instruction set, with the same bits in each.
// The sets are listed here and in isa.h.
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

/// Lanes of a pack of doubles on each instruction set, in the order of Isa.
using PackWidths = std::integer_sequence<int, 2, 4, 8>;

namespace detail {

template <class Body, class Function>
struct Kernel;

/// Body::run<W> with all that it inlines, compiled for each instruction set.
template <class Body, class Result, class... Args>
struct Kernel<Body, Result(Args...)> {
  SKYBODY_KERNEL("arch=x86-64-v2")
  static Result v2(Args... args) { return Body::template run<2>(args...); }
  SKYBODY_KERNEL("arch=x86-64-v3")
  static Result v3(Args... args) { return Body::template run<4>(args...); }
  SKYBODY_KERNEL("arch=x86-64-v4")
  static Result v4(Args... args) { return Body::template run<8>(args...); }

  static constexpr Result (*kTable[])(Args...) = {&v2, &v3, &v4};
  static_assert(sizeof(kTable) / sizeof(*kTable) == kIsaCount && PackWidths::size() == kIsaCount);
};

}  // namespace detail

/// The function that `Body::run` is compiled to for an instruction set.
/// @param isa  that the processor has, such as best_isa()
template <class Body>
constexpr auto* kernel(Isa isa) {
  return detail::Kernel<Body, decltype(Body::template run<2>)>::kTable[static_cast<int>(isa)];
}

}  // namespace skybody
