// The kernels of PackMechanics for each instruction set.
#include "core/base/isa.h"
#include "core/base/kernel_target.h"
#include "core/physics/pack_mechanics.h"

namespace skybody {
namespace {

/// The kernels for packs of W lanes.
template <int W>
struct Steps {
  using Real = Pack<W>;

  /// Calls f(first, bits) for the packs that hold any of the lanes.
  template <class F>
  static SKYBODY_INLINE void for_packs(std::uint32_t lanes, F&& f) {
    for (int first = 0; first < kGroupLanes; first += W) {
      const std::uint32_t bits = (lanes >> first) & ((1u << W) - 1u);
      if (bits != 0) f(first, bits);
    }
  }

  static SKYBODY_INLINE void refresh(const PackCall& call, std::uint32_t lanes) {
    for_packs(lanes, [&](int first, std::uint32_t) __attribute__((always_inline)) {
      const SharedValues<Real> none(nullptr);  // the motion does not ask for parameters
      PackMechanics<Real, SharedValues<Real>>(call, first, none, none).refresh();
    });
  }

  static SKYBODY_INLINE std::uint32_t advance(const PackCall& call, std::uint32_t lanes) {
    std::uint32_t through = 0;
    const auto run = [&](int first, std::uint32_t bits, const auto& params, const auto& derived)
                         __attribute__((always_inline)) {
      using Values = std::decay_t<decltype(params)>;
      PackMechanics<Real, Values> mechanics(call, first, params, derived);
      through |= bits_from_mask(mechanics.advance(mask_from_bits<Real>(bits))) << first;
    };
    if (call.derived == nullptr) {
      const SharedValues<Real> params(call.world->nominal_params.data());
      const SharedValues<Real> derived(call.world->nominal_derived.data());
      for_packs(lanes, [&](int first, std::uint32_t bits) __attribute__((always_inline)) {
        run(first, bits, params, derived);
      });
    } else {
      for_packs(lanes, [&](int first, std::uint32_t bits) __attribute__((always_inline)) {
        run(first, bits, LaneValues<Real>(call.group->params + first),
            LaneValues<Real>(call.derived + first));
      });
    }
    return through;
  }
};

// One set of functions per instruction set. A macro, because the target is an attribute.
#define SKYBODY_PACK_KERNELS(NAME, TARGET, WIDTH)                               \
  SKYBODY_KERNEL(TARGET)                                                        \
  void refresh_##NAME(const PackCall& call, std::uint32_t lanes) {              \
    Steps<WIDTH>::refresh(call, lanes);                                         \
  }                                                                             \
  SKYBODY_KERNEL(TARGET)                                                        \
  std::uint32_t advance_##NAME(const PackCall& call, std::uint32_t lanes) {     \
    return Steps<WIDTH>::advance(call, lanes);                                  \
  }
SKYBODY_PACK_KERNELS(v2, "arch=x86-64-v2", 2)
SKYBODY_PACK_KERNELS(v3, "arch=x86-64-v3", 4)
SKYBODY_PACK_KERNELS(v4, "arch=x86-64-v4", 8)
#undef SKYBODY_PACK_KERNELS

}  // namespace

const PackKernels& pack_kernels() {
  static const PackKernels chosen = [] {
    switch (best_isa()) {
      case Isa::v4:
        return PackKernels{&refresh_v4, &advance_v4};
      case Isa::v3:
        return PackKernels{&refresh_v3, &advance_v3};
      case Isa::v2:
        break;
    }
    return PackKernels{&refresh_v2, &advance_v2};
  }();
  return chosen;
}

}  // namespace skybody
