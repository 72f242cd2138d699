#include "core/env/transition_phases.h"

#include "core/base/simd/fp_environment.h"
#include "core/env/group_workspace.h"

namespace skybody {
namespace {

/// The overlaps of the scenario's own start, which are allowed in drawn starts, too.
std::unique_ptr<const StartOverlaps> find_nominal_overlaps(const ScenarioModel& model,
                                                           const EpisodeStart& start) {
  if (!model.checks_starts()) return nullptr;
  const FpEnvironment guard;
  StateGroup group = model.make_state(1);
  const std::unique_ptr<GroupWorkspace> work = model.make_workspace(1);
  start.initialize(group, 0, 0, 0);
  group.refresh(1u, work->physics);
  ContactSensing::find(group, *work, 0);
  return std::make_unique<const StartOverlaps>(*model.world, work->contacts);
}

}  // namespace

TransitionPhases::TransitionPhases(const ScenarioModel& model)
    : start(model),
      overlaps(find_nominal_overlaps(model, start)),
      draws(model, start, overlaps.get()),
      control(model),
      effects(model),
      physics(model),
      contacts(model),
      sensing(model),
      faults(model, overlaps.get()),
      outcome(model, faults) {}

}  // namespace skybody
