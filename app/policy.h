// What flies: baselines where nothing has been learned, and trained networks.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/assemble/simulation.h"

namespace CLI {
class Validator;
}

namespace skybody {

/// Chooses actions.
class Policy {
 public:
  virtual ~Policy() = default;
  /// Writes action_size() values in [-1, 1].
  virtual void act(const Simulation& simulation, std::span<float> action) = 0;
};

/// The baselines: zero, random, hold.
const std::vector<std::string>& policy_names();

/// Accepts a baseline's name, or a file or folder that exists.
CLI::Validator policy_argument();

/// @param name  one of policy_names(), or where a trained policy lies (see find_policy); a warning
///              is logged where that was trained on another scenario
/// @param seed  of `random`
/// @throws Error if the policy cannot be read or cannot fly the environment
std::unique_ptr<Policy> make_policy(const std::string& name, const Environment& environment,
                                    std::uint64_t seed);

}  // namespace skybody
