// What flies where nothing has been learned: the baselines of `skybody run`.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/assemble/simulation.h"

namespace skybody {

/// Chooses actions.
class Policy {
 public:
  virtual ~Policy() = default;
  /// Writes action_size() values in [-1, 1].
  virtual void act(const Simulation& simulation, std::span<float> action) = 0;
};

/// zero, random, hold.
const std::vector<std::string>& policy_names();

/// @param name  one of policy_names()   @param seed  of `random`
/// @throws Error if the policy cannot fly the environment
std::unique_ptr<Policy> make_policy(const std::string& name, const Environment& environment,
                                    std::uint64_t seed);

}  // namespace skybody
