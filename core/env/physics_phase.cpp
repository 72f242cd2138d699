#include "core/env/physics_phase.h"

#include "core/env/group_lanes.h"
#include "core/env/group_workspace.h"

namespace skybody {

std::uint32_t PhysicsPhase::advance(StateGroup& group, GroupWorkspace& work, std::uint32_t mask,
                                    std::int64_t steps_left) const {
  remember_bodies(group, mask);
  const std::uint32_t through = group.advance(mask, work.physics);
  work.faults.bad_state |= mask & ~through;
  count(group, kPhysicsStep, through);
  contacts_.sense_after_step(group, work, contacts_.lanes_of_contacts(group, through, steps_left));
  contacts_.sense_joint_reactions(group, work,
                                  contacts_.lanes_of_reactions(group, through, steps_left));
  return through;
}

void PhysicsPhase::remember_bodies(StateGroup& group, std::uint32_t mask) const {
  if (!model_.needs_bodies_before) return;
  const Block& block = model_.layout().bodies_before;
  keep(group, mask, block.size, group.bodies(), group.writable(block, mask));
}

}  // namespace skybody
