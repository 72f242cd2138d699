// Looking at one environment: what moves it at this instant. Nothing here changes its state.
#include "core/base/fp_environment.h"
#include "core/env/environment.h"
#include "core/env/group_work.h"

namespace skybody {

void Environment::accelerations(StateGroup& group, GroupWork& work, int lane, double* udot) const {
  const FpEnvironment guard;
  update(group, work, 1u << lane);
  GroupWork::Lane& w = work.lanes[static_cast<std::size_t>(lane)];
  group.gather(lane, layout().rotor_command, w.state.rotor_command.data());
  group.gather(lane, layout().wrench, w.state.wrench.data());
  group.gather(lane, layout().drive, w.state.drive.data());
  w.stepper->accelerations(w.state, udot);
}

std::vector<Contact> Environment::contacts(StateGroup& group, GroupWork& work, int lane) const {
  const FpEnvironment guard;
  update(group, work, 1u << lane);
  GroupWork::Lane& w = work.lanes[static_cast<std::size_t>(lane)];
  std::vector<Contact> out = ground_contacts(*world_, w.state.bodies);
  w.stepper->add_contacts(w.state, out);
  return out;
}

}  // namespace skybody
