// Functions that are compiled once for each width of packs: long code that several kernels call.
//
//   struct Meet {
//     template <int W>  // lanes; 1: of doubles
//     static SKYBODY_INLINE void run(const void* call);
//   };
//   width_function<Meet>(8)(&call);
#pragma once

#include <type_traits>

#include "core/base/kernels.h"
#include "core/base/pack.h"

namespace skybody {

/// A pack of W lanes; of one: a double.
template <int W>
using RealOf = std::conditional_t<W == 1, double, Pack<W == 1 ? 2 : W>>;

/// The function that `Body::run` is compiled to for a width that an instruction set has, or for 1.
template <class Body>
auto* width_function(int lanes) {
  constexpr int kWidths[] = {
#define SKYBODY_ROW(NAME, LANES, TARGET) LANES,
      SKYBODY_ISAS(SKYBODY_ROW)
#undef SKYBODY_ROW
  };
  if (lanes == 1) return &Body::template run<1>;
  int i = 0;
  while (kWidths[i] != lanes) ++i;
  return kernel<Body>(kIsas[i]);
}

}  // namespace skybody
