// Flies what was trained in Python: a multilayer perceptron read from policy.h5.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/io/policy_file.h"
#include "core/policy/policy.h"

namespace skybody {

/// The deterministic policy: the mean of the action distribution. Evaluated in double with sums
/// from left to right and bit-stable functions: equal observations give equal actions on every
/// machine, within 1e-6 of what the training library gives in float. A policy that a team shares is
/// evaluated once for each robot.
class NetworkPolicy : public Policy {
 public:
  /// @param path  policy.h5, a checkpoint folder or a training run's folder (see find_policy)
  /// @throws Error as find_policy() and read_policy()
  explicit NetworkPolicy(const std::filesystem::path& path);
  explicit NetworkPolicy(PolicyFile policy);

  /// What was read.
  const PolicyFile& policy() const { return policy_; }
  /// Where it was read from.
  const std::filesystem::path& file() const { return file_; }

  std::string check_fits(const CompiledScenario& compiled) const override;

  /// Allocates nothing. A value of the observation that is not finite gives actions that are not.
  /// @param observation  observation_size values   @param action  action_size values in [-1, 1]
  void act(std::span<const float> observation, std::span<float> action);
  void act(const Simulation& simulation, std::span<float> action) override {
    act(simulation.observation(), action);
  }

 private:
  void prepare();
  void act(const PolicyAgent& agent, std::span<const float> observation, std::span<float> action);

  std::filesystem::path file_;
  PolicyFile policy_;
  PolicyAgent all_;                    ///< of a policy without agents
  std::vector<double> values_, next_;  ///< between two layers, as wide as the widest
};

}  // namespace skybody
