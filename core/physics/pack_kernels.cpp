// The kernels of PackMechanics for each instruction set.
#include "core/base/isa.h"
#include "core/base/kernel_target.h"
#include "core/physics/pack_call.h"
#include "core/physics/pack_mechanics.h"

namespace skybody {
namespace {

/// The kernels for packs of W lanes.
template <int W>
struct Steps {
  using Real = Pack<W>;

  static SKYBODY_INLINE void refresh(const PackCall& call, std::uint32_t lanes) {
    const SharedValues<Real> none(nullptr);  // the motion does not ask for parameters
    for (int first = 0; first < kGroupLanes; first += W) {
      if (((lanes >> first) & ((1u << W) - 1u)) == 0) continue;
      PackMechanics<Real, SharedValues<Real>, IntegratorChoice::kSemiImplicitEuler>(call, first,
                                                                                    none, none)
          .refresh();
    }
  }

  static SKYBODY_INLINE std::uint32_t within_reach(const PackCall& call, std::uint32_t lanes) {
    const SharedValues<Real> none(nullptr);  // the motion does not ask for parameters
    std::uint32_t within = 0;
    for (int first = 0; first < kGroupLanes; first += W) {
      const std::uint32_t bits = (lanes >> first) & ((1u << W) - 1u);
      if (bits == 0) continue;
      PackMechanics<Real, SharedValues<Real>, IntegratorChoice::kSemiImplicitEuler> mechanics(
          call, first, none, none);
      within |= (bits_from_mask(mechanics.is_within_reach()) & bits) << first;
    }
    return within;
  }

  template <IntegratorChoice kIntegrator>
  static SKYBODY_INLINE std::uint32_t advance(const PackCall& call, std::uint32_t lanes) {
    return for_packs<W>(call, lanes,
                        [&](int first, std::uint32_t bits, const auto& params, const auto& derived)
                            SKYBODY_INLINE_LAMBDA {
                              using Values = std::decay_t<decltype(params)>;
                              PackMechanics<Real, Values, kIntegrator> mechanics(call, first,
                                                                                 params, derived);
                              return bits_from_mask(mechanics.advance(mask_from_bits<Real>(bits)));
                            });
  }
};

// One set of functions per instruction set. A macro, because the target is an attribute.
#define SKYBODY_PACK_KERNELS(NAME, TARGET, WIDTH)                                                \
  SKYBODY_KERNEL(TARGET)                                                                         \
  void refresh_##NAME(const PackCall& call, std::uint32_t lanes) {                               \
    Steps<WIDTH>::refresh(call, lanes);                                                          \
  }                                                                                              \
  SKYBODY_KERNEL(TARGET)                                                                         \
  std::uint32_t euler_##NAME(const PackCall& call, std::uint32_t lanes) {                        \
    return Steps<WIDTH>::advance<IntegratorChoice::kSemiImplicitEuler>(call, lanes);             \
  }                                                                                              \
  SKYBODY_KERNEL(TARGET)                                                                         \
  std::uint32_t rk4_##NAME(const PackCall& call, std::uint32_t lanes) {                          \
    return Steps<WIDTH>::advance<IntegratorChoice::kRk4>(call, lanes);                           \
  }                                                                                              \
  SKYBODY_KERNEL(TARGET)                                                                         \
  std::uint32_t reach_##NAME(const PackCall& call, std::uint32_t lanes) {                        \
    return Steps<WIDTH>::within_reach(call, lanes);                                              \
  }                                                                                              \
  PackKernels choose_##NAME(IntegratorChoice integrator) {                                       \
    return {&refresh_##NAME, integrator == IntegratorChoice::kRk4 ? &rk4_##NAME : &euler_##NAME, \
            &reach_##NAME};                                                                      \
  }
SKYBODY_PACK_KERNELS(v2, "arch=x86-64-v2", 2)
SKYBODY_PACK_KERNELS(v3, "arch=x86-64-v3", 4)
SKYBODY_PACK_KERNELS(v4, "arch=x86-64-v4", 8)
#undef SKYBODY_PACK_KERNELS

}  // namespace

PackKernels choose_pack_kernels(IntegratorChoice integrator) {
  switch (best_isa()) {
    case Isa::v4:
      return choose_v4(integrator);
    case Isa::v3:
      return choose_v3(integrator);
    case Isa::v2:
      break;
  }
  return choose_v2(integrator);
}

}  // namespace skybody
