// What derives from drawn parameters of rotors, on packs, for each instruction set: the
// exponentials of their lags are most of what a reset with drawn constants costs.
#include "core/base/isa.h"
#include "core/base/kernel_target.h"
#include "core/physics/group_stepper.h"
#include "core/physics/lane_values.h"
#include "core/physics/pack_world.h"

namespace skybody {
namespace {

template <int W>
SKYBODY_INLINE void derive(const PackCall& call, std::uint32_t lanes, double* derived) {
  using Real = Pack<W>;
  for (int first = 0; first < kGroupLanes; first += W) {
    const std::uint32_t bits = (lanes >> first) & ((1u << W) - 1u);
    if (bits == 0) continue;
    const MaskOf<Real> mask = mask_from_bits<Real>(bits);
    derive_rotors(
        call.world->world, call.world->derived, LaneValues<Real>(call.group->params + first),
        [&](int k, const Real& value) SKYBODY_INLINE_LAMBDA {
          store_lanes(derived + static_cast<std::ptrdiff_t>(k) * kGroupLanes + first, value, mask);
        });
  }
}

// One function per instruction set. A macro, because the target is an attribute.
#define SKYBODY_DERIVE_KERNEL(NAME, TARGET, WIDTH)                                 \
  SKYBODY_KERNEL(TARGET)                                                           \
  void derive_##NAME(const PackCall& call, std::uint32_t lanes, double* derived) { \
    derive<WIDTH>(call, lanes, derived);                                           \
  }
SKYBODY_DERIVE_KERNEL(v2, "arch=x86-64-v2", 2)
SKYBODY_DERIVE_KERNEL(v3, "arch=x86-64-v3", 4)
SKYBODY_DERIVE_KERNEL(v4, "arch=x86-64-v4", 8)
#undef SKYBODY_DERIVE_KERNEL

}  // namespace

PackDerive* choose_derive_kernel() {
  switch (best_isa()) {
    case Isa::v4:
      return &derive_v4;
    case Isa::v3:
      return &derive_v3;
    case Isa::v2:
      break;
  }
  return &derive_v2;
}

}  // namespace skybody
