// Direct control: physics steps and the task's judgement one by one, and what moves an environment
// at this instant.
#include "core/base/fp_environment.h"
#include "core/base/octets.h"
#include "core/env/environment.h"
#include "core/env/group_lanes.h"
#include "core/env/group_work.h"

namespace skybody {

std::uint32_t Environment::advance(StateGroup& group, GroupWork& work, std::uint32_t mask,
                                   std::int64_t physics_steps) const {
  check(group, work, mask);
  const FpEnvironment guard;
  update(group, work, mask);
  const std::uint32_t through = fly(group, work, view(group, mask), physics_steps);
  each_lane(mask & ~through,
            [&](int lane) { group.writable(kStatus)[lane] = kTruncated | kFault | kBadState; });
  return through;
}

void Environment::evaluate(StateGroup& group, GroupWork& work, std::uint32_t mask,
                           const Rows& rows) const {
  check(group, work, mask);
  const FpEnvironment guard;
  work.bad_action = work.bad_state = 0;
  count(group, kStep, mask);
  each_lane(mask, [&](int lane) {  // advance() has left its faults in the status
    if ((group.bits(kStatus)[lane] & kBadState) != 0) work.bad_state |= 1u << lane;
  });
  update(group, work, mask);
  evaluate(group, work, view(group, mask), rows.info != nullptr);
  conclude(group, work, mask, false, rows);
}

void Environment::accelerations(StateGroup& group, GroupWork& work, int lane, double* udot) const {
  const FpEnvironment guard;
  group.accelerations(lane, work.physics, udot);
}

std::vector<Contact> Environment::contacts(StateGroup& group, GroupWork& work, int lane) const {
  const FpEnvironment guard;
  update(group, work, 1u << lane);
  std::vector<double> params(static_cast<std::size_t>(layout().params.size));
  group.gather(lane, layout().params, params.data());
  std::vector<Contact> out = ground_contacts(*world_, params.data(), group.body_states(lane));
  group.add_contacts(lane, work.physics, out);
  return out;
}

}  // namespace skybody
