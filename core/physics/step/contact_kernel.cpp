// Kernels of contact, of any world.
#include "core/physics/step/contact_correction.h"
#include "core/physics/step/group_kernels.h"

namespace skybody {
namespace {

/// Calls f(correction, lanes as a mask, lanes as bits) for every pack.
template <int W, class F>
SKYBODY_INLINE std::uint32_t each_correction(const StepCall& call, std::uint32_t lanes,
                                             const F& f) {
  using Real = RealOf<W>;
  return for_packs<W, false>(
      call, lanes,
      [&](int first, std::uint32_t bits, const auto& params, const auto& derived)
          SKYBODY_INLINE_LAMBDA {
            using Values = std::decay_t<decltype(params)>;
            ContactCorrection<Real, Values> correction(call, first, params, derived);
            return bits_from_mask(f(correction, mask_from_bits<Real>(bits))) & bits;
          });
}

struct FindNear {
  template <int W>
  static SKYBODY_INLINE std::uint32_t run(const StepCall& call, std::uint32_t lanes) {
    return each_correction<W>(call, lanes,
                              [](auto& correction, const auto& mask)
                                  SKYBODY_INLINE_LAMBDA { return correction.is_near(mask); });
  }
};

struct Correct {
  template <int W>
  static SKYBODY_INLINE std::uint32_t run(const StepCall& call, std::uint32_t lanes) {
    return each_correction<W>(call, lanes,
                              [](auto& correction, const auto& mask)
                                  SKYBODY_INLINE_LAMBDA { return correction.correct(mask); });
  }
};

}  // namespace

StepKernel* near_kernel(int lanes, Isa isa) { return kernel_for<FindNear>(lanes, isa); }
StepKernel* contact_kernel(int lanes, Isa isa) { return kernel_for<Correct>(lanes, isa); }

}  // namespace skybody
