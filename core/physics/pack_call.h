// How a kernel goes through the packs of a group.
#pragma once

#include "core/physics/group_stepper.h"
#include "core/physics/lane_values.h"
#include "core/physics/pack_world.h"

namespace skybody {

/// Calls f(first, bits, params, derived) for every pack of W lanes that holds any of `lanes`, with
/// views of the parameters and of what derives from them: shared where all lanes are nominal.
/// @returns what f returns for each pack, together: bit i is lane i of the group
template <int W, class F>
SKYBODY_INLINE std::uint32_t for_packs(const PackCall& call, std::uint32_t lanes, F&& f) {
  using Real = Pack<W>;
  const SharedValues<Real> params(call.world->nominal_params.data());
  const SharedValues<Real> derived(call.world->nominal_derived.data());
  std::uint32_t result = 0;
  for (int first = 0; first < kGroupLanes; first += W) {
    const std::uint32_t bits = (lanes >> first) & ((1u << W) - 1u);
    if (bits == 0) continue;
    if (call.derived == nullptr) {
      result |= f(first, bits, params, derived) << first;
    } else {
      result |= f(first, bits, LaneValues<Real>(call.group->params + first),
                  LaneValues<Real>(call.derived + first))
                << first;
    }
  }
  return result;
}

}  // namespace skybody
