// Inputs held by effects over a physics step. Each effect adds to inputs of its own; if several
// hold one input, their contributions are combined afterwards. An effect that is not due keeps its
// last values; a steady effect keeps them until parameters are written.
#pragma once

#include <cstdint>

#include "core/env/scenario_model.h"

namespace skybody {

/// Immutable; refers to the model, which must outlive it.
class EffectsPhase {
 public:
  explicit EffectsPhase(const ScenarioModel& model) : model_(model) {}

  /// Calls the effects that are due, in order.
  void apply(StateGroup& group, const SkybodyLanes& view) const;
  /// Sets all held inputs to their neutral values, until effects are called.
  void clear(StateGroup& group, std::uint32_t mask) const;

 private:
  void add_up(StateGroup& group, std::uint32_t mask, int input) const;

  const ScenarioModel& model_;
};

}  // namespace skybody
