// One physics step with the inputs held, and the contacts and joint reactions after it.
#pragma once

#include <cstdint>

#include "core/env/contact_sensing.h"
#include "core/env/scenario_model.h"

namespace skybody {

/// Immutable; refers to the model, which must outlive it.
class PhysicsPhase {
 public:
  explicit PhysicsPhase(const ScenarioModel& model) : model_(model), contacts_(model) {}

  /// x_{k-1} -> x_k. Lanes whose physics fails keep their last finite state and get a fault.
  /// @param steps_left  as SensingPhase::sense_due
  /// @returns the lanes that succeeded
  std::uint32_t advance(StateGroup& group, GroupWorkspace& work, std::uint32_t mask,
                        std::int64_t steps_left) const;
  /// Stores the present motion of bodies, for plugins that read it after the step.
  void remember_bodies(StateGroup& group, std::uint32_t mask) const;

 private:
  const ScenarioModel& model_;
  ContactSensing contacts_;
};

}  // namespace skybody
