// Episodes that a policy was not trained in.
#pragma once

#include <cstdint>
#include <memory>

#include "core/env/compiled_scenario.h"
#include "core/io/policy_file.h"

namespace skybody::bench {

/// Of kHeldOut episodes, each judged by its last 50 steps.
struct HeldOut {
  double median = 0.0;       ///< distance from the goal [m], the mean over an episode's last steps
  double worst_tenth = 0.0;  ///< nine of ten episodes end nearer [m]
  double mean_return = 0.0;
  int failures = 0;  ///< episodes that the task ended, or a fault
};

inline constexpr int kHeldOut = 100;

/// Flies the policy as `skybody run --policy` does, at the scenario's own physics steps.
/// @param compiled  a scenario with a horizon, whose task gives a distance from the goal
/// @throws Error where it does not, or the policy does not fit
HeldOut fly_held_out(const std::shared_ptr<const CompiledScenario>& compiled,
                     const PolicyFile& policy, std::uint64_t seed);

}  // namespace skybody::bench
