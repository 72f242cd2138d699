// Calls of the sensors.
#pragma once

#include <cstdint>

#include "core/env/scenario_model.h"

namespace skybody {

/// Immutable; refers to the model, which must outlive it.
class SensingPhase {
 public:
  explicit SensingPhase(const ScenarioModel& model) : model_(model) {}

  /// Calls the sensors that are due after a physics step, each lane by its own count. A sensor that
  /// is called only when read is skipped if it is due again before the next read. It may have to
  /// catch up on skipped calls, so at most SKYBODY_LONGEST_LEFT_OUT steps are skipped.
  /// @param steps_left  physics steps after this one before the outputs are read by anything but
  ///   plugins
  void sense_due(StateGroup& group, const SkybodyLanes& view, std::int64_t steps_left) const;
  /// Calls all sensors.
  void sense_all(StateGroup& group, const SkybodyLanes& view) const;
  /// Calls the sensors with observed images, to draw them again after a restore.
  void draw_again(StateGroup& group, const SkybodyLanes& view) const;

 private:
  void sense(StateGroup& group, const SkybodyLanes& view, const PluginInstance& sensor,
             std::uint64_t steps_to_read) const;

  const ScenarioModel& model_;
};

}  // namespace skybody
