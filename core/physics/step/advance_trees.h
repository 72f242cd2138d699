// Kernels that step any world with the tree's algorithms.
#pragma once

#include "core/physics/step/equations_of_motion.h"
#include "core/physics/step/group_kernels.h"

namespace skybody {

template <TreeKind kKind>
struct AdvanceTrees {
  template <int W>
  static SKYBODY_INLINE std::uint32_t run(const StepCall& call, std::uint32_t lanes) {
    using Real = RealOf<W>;
    StepArrays<Real> arrays(*call.plan, call.scratch);
    return for_packs<W, kKind == TreeKind::kAny>(
        call, lanes,
        [&](int first, std::uint32_t bits, const auto& params, const auto& derived)
            SKYBODY_INLINE_LAMBDA {
              using Values = std::decay_t<decltype(params)>;
              return bits_from_mask(
                  EquationsOfMotion<Real, Values, kKind>(call, first, params, derived, arrays)
                      .advance(mask_from_bits<Real>(bits)));
            });
  }
};

}  // namespace skybody
