// Loops of kernels over the lanes of a group: pack by pack, or one lane as a double.
#pragma once

#include "core/base/simd/kernel_width.h"
#include "core/physics/step/group_stepper.h"
#include "core/physics/step/step_plan.h"

namespace skybody {

/// Calls f(first, bits) for every pack of W lanes that contains any of `lanes`.
/// @returns the combined results of f: bit i is lane i of the group
template <int W, class F>
SKYBODY_INLINE std::uint32_t each_pack(std::uint32_t lanes, const F& f) {
  constexpr int kLanes = W == 1 ? 1 : kGroupLanes;
  std::uint32_t result = 0;
  for (int first = 0; first < kLanes; first += W) {
    const std::uint32_t bits = (lanes >> first) & ((1u << W) - 1u);
    if (bits != 0) result |= f(first, bits) << first;
  }
  return result;
}

/// The same with f(first, bits, params, derived): views of the parameters and of values derived
/// from them. All lanes share them if all are nominal.
/// @tparam kNeverShared  each lane reads its own, nominal or not (StepPlan::never_shares)
template <int W, bool kNeverShared, class F>
SKYBODY_INLINE std::uint32_t for_packs(const StepCall& call, std::uint32_t lanes, const F& f) {
  using Real = RealOf<W>;
  if constexpr (!kNeverShared) {
    if (call.derived == nullptr) {
      const SharedValues<Real> params(call.plan->shared_params.data());
      const SharedValues<Real> derived(call.plan->shared_derived.data());
      return each_pack<W>(lanes, [&](int first, std::uint32_t bits) SKYBODY_INLINE_LAMBDA {
        return f(first, bits, params, derived);
      });
    }
  }
  return each_pack<W>(lanes, [&](int first, std::uint32_t bits) SKYBODY_INLINE_LAMBDA {
    return f(first, bits, LaneValues<Real>(call.group->params + first),
             LaneValues<Real>(call.derived + first));
  });
}

/// The kernel for groups of one lane, or of kGroupLanes.
template <class Body>
StepKernel* kernel_for(int lanes, Isa isa) {
  return lanes == 1 ? &Body::template run<1> : kernel<Body>(isa);
}

}  // namespace skybody
