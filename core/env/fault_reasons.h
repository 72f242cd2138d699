// The causes of faults: as status bits of a lane, and in words.
#pragma once

#include <cstdint>
#include <string>

#include "core/env/scenario_model.h"
#include "core/env/start_overlaps.h"

namespace skybody {

/// Immutable; refers to its arguments, which must outlive it.
class FaultReasons {
 public:
  /// @param overlaps  null: starts are not checked
  FaultReasons(const ScenarioModel& model, const StartOverlaps* overlaps)
      : model_(model), overlaps_(overlaps) {}

  /// kBadState with the index of the body whose inertia is not physical, or else with the likely
  /// cause.
  std::uint64_t bad_state_bits(const StateGroup& group, int lane) const;
  /// @param status  EpisodeStatus bits
  /// @returns the reasons, separated by "; "; empty: no fault
  std::string text(std::uint64_t status) const;

 private:
  std::string impossible_body_text(std::uint64_t status) const;

  const ScenarioModel& model_;
  const StartOverlaps* overlaps_;
};

}  // namespace skybody
