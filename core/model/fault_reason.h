// Texts of the reasons why an episode ended as a fault.
#pragma once

#include <string>

#include "core/model/state_layout.h"

namespace skybody {

/// CompiledScenario::fault_reason() gives more details of a bad start.
/// @param status  EpisodeStatus bits @returns the reasons, separated by "; "; empty: no fault
inline std::string fault_reason(std::uint64_t status) {
  struct Row {
    EpisodeStatus bit;
    const char* text;
  };
  static constexpr Row kRows[] = {
      {kBadAction, "the action was not finite"},
      {kBadState, "the physics gave up or left the finite numbers"},
      {kBadOutcome, "an observed value or the reward was not finite as a float"},
      {kBadStart, "a robot begins inside something"},
  };
  std::string reasons;
  if ((status & kFault) == 0) return reasons;
  for (const Row& row : kRows) {
    if ((status & row.bit) != 0) reasons += (reasons.empty() ? "" : "; ") + std::string(row.text);
  }
  return reasons;
}

/// World body index of the body whose inertia is not physical; -1 if the status has no such index.
/// Bits above the index encode other causes (core/env/fault_cause.h).
inline int impossible_body(std::uint64_t status) {
  constexpr int kIndexBits = 10;
  const std::uint64_t behind = status >> kBadStartPlace;
  if ((status & kBadState) == 0 || (status & kBadStart) != 0 || behind >> kIndexBits != 0)
    return -1;
  return static_cast<int>(behind) - 1;
}

}  // namespace skybody
