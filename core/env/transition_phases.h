// The phases of a transition (paper eq. 3), each a type with the data that it needs. "The way of an
// action" in docs/architecture.md gives their order; CompiledScenario calls them in that order, and
// core/derivative one by one.
#pragma once

#include <memory>

#include "core/env/control_phase.h"
#include "core/env/effects_phase.h"
#include "core/env/episode_draws.h"
#include "core/env/episode_start.h"
#include "core/env/fault_reasons.h"
#include "core/env/outcome_phase.h"
#include "core/env/physics_phase.h"
#include "core/env/sensing_phase.h"
#include "core/env/start_overlaps.h"

namespace skybody {

/// All phases of one scenario. Immutable; refers to the model, which must outlive it.
struct TransitionPhases {
  explicit TransitionPhases(const ScenarioModel& model);
  TransitionPhases(const TransitionPhases&) = delete;
  TransitionPhases& operator=(const TransitionPhases&) = delete;

  EpisodeStart start;
  std::unique_ptr<const StartOverlaps> overlaps;  ///< null: starts are not checked
  EpisodeDraws draws;
  ControlPhase control;
  EffectsPhase effects;
  PhysicsPhase physics;
  ContactSensing contacts;
  SensingPhase sensing;
  FaultReasons faults;
  OutcomePhase outcome;
};

}  // namespace skybody
