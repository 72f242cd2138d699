// Kernels for any world.
#include "core/physics/step/equations_of_motion.h"
#include "core/physics/step/group_kernels.h"

namespace skybody {
namespace {

/// EquationsOfMotion for operations that use no parameters.
template <class Real>
SKYBODY_INLINE EquationsOfMotion<Real, SharedValues<Real>, TreeKind::kUsual> motion_of(
    const StepCall& call, int first, StepArrays<Real>& arrays) {
  const SharedValues<Real> none(nullptr);
  return {call, first, none, none, arrays};
}

struct Refresh {
  template <int W>
  static SKYBODY_INLINE std::uint32_t run(const StepCall& call, std::uint32_t lanes) {
    StepArrays<RealOf<W>> arrays(*call.plan, call.scratch);
    return each_pack<W>(lanes, [&](int first, std::uint32_t bits) SKYBODY_INLINE_LAMBDA {
      motion_of(call, first, arrays).refresh(mask_from_bits<RealOf<W>>(bits));
      return bits;
    });
  }
};

struct CloseGaps {
  template <int W>
  static SKYBODY_INLINE std::uint32_t run(const StepCall& call, std::uint32_t lanes) {
    using Real = RealOf<W>;
    StepArrays<Real> arrays(*call.plan, call.scratch);
    return for_packs<W, false>(
        call, lanes,
        [&](int first, std::uint32_t bits, const auto& params,
            const auto& derived) SKYBODY_INLINE_LAMBDA {
          using Values = std::decay_t<decltype(params)>;
          EquationsOfMotion<Real, Values, TreeKind::kUsual> mechanics(call, first, params, derived,
                                                                      arrays);
          return bits_from_mask(mechanics.project_constraints(mask_from_bits<Real>(bits))) & bits;
        });
  }
};

/// The exponentials of the rotors' lags are most of the cost of a reset with randomized constants.
struct DeriveRotors {
  template <int W>
  static SKYBODY_INLINE std::uint32_t run(const StepCall& call, std::uint32_t lanes) {
    using Real = RealOf<W>;
    return each_pack<W>(lanes, [&](int first, std::uint32_t bits) SKYBODY_INLINE_LAMBDA {
      const LaneSlice<Real> place(first);
      const MaskOf<Real> mask = mask_from_bits<Real>(bits);
      derive_rotors(
          call.plan->world, call.plan->derived, LaneValues<Real>(call.group->params + first),
          [&](int k, const Real& value)
              SKYBODY_INLINE_LAMBDA { place.put(value, mask, place.at(call.derived, k)); });
      return bits;
    });
  }
};

}  // namespace

StepKernel* refresh_kernel(int lanes, Isa isa) { return kernel_for<Refresh>(lanes, isa); }
StepKernel* gap_kernel(int lanes, Isa isa) { return kernel_for<CloseGaps>(lanes, isa); }
StepKernel* derive_kernel(int lanes, Isa isa) { return kernel_for<DeriveRotors>(lanes, isa); }

}  // namespace skybody
