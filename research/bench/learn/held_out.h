// Episodes that a policy was not trained in.
#pragma once

#include <cstdint>
#include <memory>

#include "core/env/compiled_scenario.h"
#include "core/io/files/policy_file.h"

namespace skybody::bench {

/// Results of kHeldOut episodes, measured over the last 50 steps of each.
struct HeldOut {
  double median = 0.0;       ///< distance from the goal [m], mean over an episode's last steps
  double worst_tenth = 0.0;  ///< nine of ten episodes end closer [m]
  double mean_return = 0.0;
  int failures = 0;  ///< episodes that ended by the task or a fault
};

inline constexpr int kHeldOut = 100;

/// Flies the policy like `skybody run --policy`, at the scenario's own physics steps.
/// @param compiled  a scenario with a horizon, whose task reports a distance from the goal
/// @throws Error if it does not, or if the policy does not fit
HeldOut fly_held_out(const std::shared_ptr<const CompiledScenario>& compiled,
                     const PolicyFile& policy, std::uint64_t seed);

}  // namespace skybody::bench
