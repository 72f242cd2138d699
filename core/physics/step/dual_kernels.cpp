#include "core/physics/step/dual_kernels.h"

#include "core/physics/step/equations_of_motion.h"
#include "core/physics/step/group_kernels.h"

namespace skybody {
namespace {

/// Held inputs are possible. Worlds without them use the same code, with no input held.
template <class Real>
using DualEquations = EquationsOfMotion<Real, ConstantValues<Real>, TreeKind::kAny>;

/// Calls f(mechanics, mask) for every pack that contains any of `lanes`.
template <int W, class F>
SKYBODY_INLINE void each_dual_pack(const StepCall& call, std::uint32_t lanes, const F& f) {
  using Real = Dual<RealOf<W>>;
  StepArrays<Real> arrays(*call.plan, call.scratch);
  each_pack<W>(lanes, [&](int first, std::uint32_t bits) SKYBODY_INLINE_LAMBDA {
    DualEquations<Real> mechanics(call, first, ConstantValues<Real>(call.group->params + first),
                                  ConstantValues<Real>(call.derived + first), arrays);
    f(mechanics, mask_from_bits<Real>(bits));
    return bits;
  });
}

struct DualStep {
  template <int W>
  static SKYBODY_INLINE void run(const StepCall& call, std::uint32_t lanes) {
    each_dual_pack<W>(call, lanes, [](auto& mechanics, const auto& mask) SKYBODY_INLINE_LAMBDA {
      mechanics.advance(mask);
    });
  }
};

struct DualMotion {
  template <int W>
  static SKYBODY_INLINE void run(const StepCall& call, std::uint32_t lanes) {
    each_dual_pack<W>(call, lanes, [](auto& mechanics, const auto& mask) SKYBODY_INLINE_LAMBDA {
      mechanics.find_motion(mask);
    });
  }
};

}  // namespace

DualKernel* dual_motion_kernel(Isa isa) { return kernel<DualMotion>(isa); }
DualKernel* dual_step_kernel(Isa isa) { return kernel<DualStep>(isa); }

std::size_t dual_scratch_bytes(const StepPlan& plan) {
  return StepArrays<Dual<Pack<kWidestPack>>>::bytes(plan);
}

}  // namespace skybody
