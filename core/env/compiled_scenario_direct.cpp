// Direct control: physics steps and the task's evaluation one by one, and accelerations at the
// current instant.
#include "core/base/simd/fp_environment.h"
#include "core/base/simd/lane_mask.h"
#include "core/env/compiled_scenario.h"
#include "core/env/group_lanes.h"
#include "core/env/group_workspace.h"

namespace skybody {
std::uint32_t CompiledScenario::advance(StateGroup& group, GroupWorkspace& work, std::uint32_t mask,
                                        std::int64_t physics_steps) const {
  check(group, work, mask);
  const FpEnvironment guard;
  update(group, work, mask);
  SkybodyLanes lanes = view(group, work, mask);
  for (std::int64_t k = 0; k < physics_steps && lanes.active != 0; ++k) {
    physics_step(group, work, lanes, physics_steps - 1 - k);
  }
  each_lane(mask & ~lanes.active, [&](int lane) {
    group.writable(kStatus)[lane] = kTruncated | kFault | bad_state_bits(group, lane);
  });
  return lanes.active;
}

void CompiledScenario::evaluate(StateGroup& group, GroupWorkspace& work, std::uint32_t mask,
                                const Rows& rows) const {
  check(group, work, mask);
  const FpEnvironment guard;
  work.clear_faults();
  count(group, kStep, mask);
  each_lane(mask, [&](int lane) {  // advance() has left its faults in the status
    if ((group.bits(kStatus)[lane] & kBadState) != 0) work.bad_state |= 1u << lane;
  });
  update(group, work, mask);
  evaluate(group, work, view(group, work, mask), rows.info != nullptr);
  finish_transition(group, work, mask, false, rows);
}

void CompiledScenario::accelerations(StateGroup& group, GroupWorkspace& work, int lane,
                                     double* udot) const {
  const FpEnvironment guard;
  group.accelerations(lane, work.physics, udot);
}

}  // namespace skybody
