// Functions compiled once per pack width: long code shared by several kernels.
//
//   struct Meet {
//     template <int W>  // lanes; 1: double
//     static SKYBODY_INLINE void run(const void* call);
//   };
//   width_function<Meet>(8)(&call);
#pragma once

#include <type_traits>

#include "core/base/simd/kernels.h"
#include "core/base/simd/pack.h"

namespace skybody {

/// Pack<W>, or double for W = 1.
template <int W>
using RealOf = std::conditional_t<W == 1, double, Pack<W == 1 ? 2 : W>>;

/// `Body::run` compiled for `lanes` lanes: 1, or the pack width of an instruction set.
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
