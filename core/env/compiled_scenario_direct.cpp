// Direct control: physics steps and the task's judgement one by one, and what moves an environment
// at this instant.
#include <array>

#include "core/base/fp_environment.h"
#include "core/base/octets.h"
#include "core/env/compiled_scenario.h"
#include "core/env/group_lanes.h"
#include "core/env/group_work.h"

namespace skybody {
namespace {

/// Adds a contact to what a body feels. @param sign  -1: the body is the other one
void add_contact(const Contact& contact, int body, double sign, const StateGroup& group, int lane,
                 double* sums) {
  const int lanes = group.lanes();
  const double* at = group.bodies() + 13 * body * lanes + lane;
  const Vec3<double> arm = contact.point - Vec3<double>{at[0], at[lanes], at[2 * lanes]};
  const Vec3<double> force = sign * contact.force, moment = cross(arm, force);
  double* sum = sums + SKYBODY_CONTACT_VALUES * body * lanes + lane;
  for (const double value : {force.x, force.y, force.z, moment.x, moment.y, moment.z}) {
    *sum += value;
    sum += lanes;
  }
  *sum = 1.0;
}

}  // namespace

std::uint32_t CompiledScenario::advance(StateGroup& group, GroupWork& work, std::uint32_t mask,
                                        std::int64_t physics_steps) const {
  check(group, work, mask);
  const FpEnvironment guard;
  update(group, work, mask);
  SkybodyLanes lanes = view(group, work, mask);
  for (std::int64_t k = 0; k < physics_steps && lanes.active != 0; ++k) {
    fly(group, work, lanes, physics_steps - 1 - k);
  }
  each_lane(mask & ~lanes.active,
            [&](int lane) { group.writable(kStatus)[lane] = kTruncated | kFault | kBadState; });
  return lanes.active;
}

void CompiledScenario::evaluate(StateGroup& group, GroupWork& work, std::uint32_t mask,
                                const Rows& rows) const {
  check(group, work, mask);
  const FpEnvironment guard;
  work.bad_action = work.bad_state = 0;
  count(group, kStep, mask);
  each_lane(mask, [&](int lane) {  // advance() has left its faults in the status
    if ((group.bits(kStatus)[lane] & kBadState) != 0) work.bad_state |= 1u << lane;
  });
  update(group, work, mask);
  evaluate(group, work, view(group, work, mask), rows.info != nullptr);
  conclude(group, work, mask, false, rows);
}

void CompiledScenario::accelerations(StateGroup& group, GroupWork& work, int lane,
                                     double* udot) const {
  const FpEnvironment guard;
  group.accelerations(lane, work.physics, udot);
}

std::vector<Contact> CompiledScenario::contacts(StateGroup& group, GroupWork& work,
                                                int lane) const {
  const FpEnvironment guard;
  update(group, work, 1u << lane);
  return find_contacts(group, work, lane);
}

/// Of a lane that is up to date.
std::vector<Contact> CompiledScenario::find_contacts(StateGroup& group, GroupWork& work,
                                                     int lane) const {
  std::array<double, kWorldParamCount> constants;
  const Block block{layout().params.offset + layout().world_params, kWorldParamCount};
  group.gather(lane, block, constants.data());
  std::vector<Contact> out = ground_contacts(*world_, constants.data(), group.body_states(lane));
  group.add_contacts(lane, work.physics, out);
  return out;
}

/// What touches each body, added up, for plugins that ask.
void CompiledScenario::sense_contacts(StateGroup& group, GroupWork& work,
                                      std::uint32_t mask) const {
  if (!needs_contacts_ || mask == 0) return;
  const int lanes = group.lanes();
  double* sums = group.writable(layout().contacts, mask);
  each_lane(mask, [&](int lane) {
    const std::vector<Contact> contacts = find_contacts(group, work, lane);
    for (int k = 0; k < layout().contacts.size; ++k) sums[k * lanes + lane] = 0.0;
    for (const Contact& contact : contacts) {
      add_contact(contact, contact.body, 1.0, group, lane, sums);
      if (contact.other >= 0) add_contact(contact, contact.other, -1.0, group, lane, sums);
    }
  });
}

}  // namespace skybody
