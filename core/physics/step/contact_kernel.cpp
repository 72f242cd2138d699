// Contact kernels for any world.
#include "core/physics/step/broad_phase_update.h"
#include "core/physics/step/contact_substeps.h"
#include "core/physics/step/group_kernels.h"
#include "core/physics/world/lane_list.h"

namespace skybody {
namespace {

/// Calls f(list, bits) for lists of lanes that together hold all of `lanes`: the packs that contain
/// them, or gathered lanes if these need fewer lists.
/// @returns the combined results of f: bit i is lane i of the group
template <int W, class F>
SKYBODY_INLINE std::uint32_t each_list(std::uint32_t lanes, const F& f) {
  using Real = RealOf<W>;
  int packs = 0;
  for (std::uint32_t left = lanes; left != 0 && W > 1; ++packs) {
    const int first = std::countr_zero(left) / W * W;
    left &= ~(((1u << W) - 1u) << first);
  }
  const bool is_gathered = (std::popcount(lanes) + W - 1) / W < packs;
  std::uint32_t result = 0;
  while (lanes != 0) {
    LaneList<Real> list(std::countr_zero(lanes) / W * W);
    std::uint32_t bits = lanes >> list.first() & ((1u << W) - 1u);
    if (is_gathered) {
      list = LaneList<Real>::take(lanes, bits);
    } else {
      lanes &= ~(bits << list.first());
    }
    result |= list.in_group(f(list, bits));
  }
  return result;
}

/// Calls f(list, bits, params, derived) for such lists, like for_packs().
template <int W, class F>
SKYBODY_INLINE std::uint32_t for_lists(const StepCall& call, std::uint32_t lanes, const F& f) {
  using Real = RealOf<W>;
  if (call.derived == nullptr) {
    const SharedValues<Real> params(call.plan->shared_params.data());
    const SharedValues<Real> derived(call.plan->shared_derived.data());
    return each_list<W>(lanes,
                        [&](const LaneList<Real>& list, std::uint32_t bits)
                            SKYBODY_INLINE_LAMBDA { return f(list, bits, params, derived); });
  }
  return each_list<W>(lanes,
                      [&](const LaneList<Real>& list, std::uint32_t bits) SKYBODY_INLINE_LAMBDA {
                        return f(list, bits, ListedValues<Real>(call.group->params, list),
                                 ListedValues<Real>(call.derived, list));
                      });
}

template <class Real, class Values>
using ListCorrection = ContactSubsteps<Real, Values, TreeResponse, LaneList<Real>>;

struct FindNear {
  template <int W>
  static SKYBODY_INLINE std::uint32_t run(const StepCall& call, std::uint32_t lanes) {
    using Real = RealOf<W>;
    std::uint32_t unclear = 0;
    const std::uint32_t near = for_packs<W, false>(
        call, lanes,
        [&](int first, std::uint32_t bits, const auto&, const auto& derived) SKYBODY_INLINE_LAMBDA {
          const BroadPhaseUpdate<Real, std::decay_t<decltype(derived)>> search(call, first,
                                                                               derived);
          MaskOf<Real> is_unclear;
          const auto is_near = search.find(mask_from_bits<Real>(bits), is_unclear);
          unclear |= (bits_from_mask(is_unclear) & bits) << first;
          return bits_from_mask(is_near) & bits;
        });
    if (unclear == 0) return near;
    return near | for_lists<W>(call, unclear,
                               [&](const LaneList<Real>& list, std::uint32_t bits, const auto&,
                                   const auto& derived) SKYBODY_INLINE_LAMBDA {
                                 using Values = std::decay_t<decltype(derived)>;
                                 const BroadPhaseUpdate<Real, Values, LaneList<Real>> search(
                                     call, list, derived);
                                 const auto mask = mask_from_bits<Real>(bits);
                                 return bits_from_mask(search.measure(mask)) & bits;
                               });
  }
};

struct Correct {
  template <int W>
  static SKYBODY_INLINE std::uint32_t run(const StepCall& call, std::uint32_t lanes) {
    using Real = RealOf<W>;
    CorrectionArrays<Real> arrays(*call.plan, call.scratch);
    return for_lists<W>(
        call, lanes,
        [&](const LaneList<Real>& list, std::uint32_t bits, const auto& params, const auto& derived)
            SKYBODY_INLINE_LAMBDA {
              using Values = std::decay_t<decltype(params)>;
              ListCorrection<Real, Values> correction(call, list, params, derived, arrays);
              return bits_from_mask(correction.correct(mask_from_bits<Real>(bits))) & bits;
            });
  }
};

}  // namespace

StepKernel* near_kernel(int lanes, Isa isa) { return kernel_for<FindNear>(lanes, isa); }
StepKernel* contact_kernel(int lanes, Isa isa) { return kernel_for<Correct>(lanes, isa); }

}  // namespace skybody
