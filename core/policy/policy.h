// Interface of policies: baselines without learning, and trained networks.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/math/math.h"
#include "core/simulation/simulation.h"

namespace skybody {

/// Chooses actions.
class Policy {
 public:
  virtual ~Policy() = default;
  /// Writes action_size() values in [-1, 1].
  virtual void act(const Simulation& simulation, std::span<float> action) = 0;
  /// @returns a warning if the policy was made for another scenario, else ""
  /// @throws Error if its sizes differ from the environment's
  virtual std::string check_fits(const CompiledScenario&) const { return ""; }
  /// Number of action values so far that were outside [-1, 1] and were clipped.
  std::uint64_t clipped() const { return clipped_; }

 protected:
  /// Clips a value of an action to [-1, 1].
  float clip_action(double value) {
    if (value < -1.0 || value > 1.0) ++clipped_;
    return static_cast<float>(clamp(value, -1.0, 1.0));
  }

 private:
  std::uint64_t clipped_ = 0;
};

/// The baselines: zero, random, hold.
const std::vector<std::string>& policy_names();

/// Name of the trained policy that Skybody ships for a scenario.
inline constexpr const char* kShippedPolicy = "shipped";

/// The file of the policy that is shipped for the scenario called `scenario`.
/// @param trained  the argument of `skybody train` for that scenario: its name, or its file
/// @throws Error if there is none, with a list of the shipped ones
std::filesystem::path shipped_policy_file(const std::string& scenario, const std::string& trained);

/// @param name  one of policy_names(), kShippedPolicy, or the path of a trained policy (see
///   find_policy)
/// @param seed  of `random`
/// @throws Error if the policy cannot be read, or none is shipped for the scenario; baselines also
///   if they cannot fly the environment
std::unique_ptr<Policy> make_policy(const std::string& name, const CompiledScenario& compiled,
                                    std::uint64_t seed);

}  // namespace skybody
