// Flies trained policies: networks read from policy.h5.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/io/files/policy_file.h"
#include "core/policy/network_evaluator.h"
#include "core/policy/policy.h"

namespace skybody {

/// The deterministic policy: the mean of the action distribution, evaluated by a NetworkEvaluator.
/// A policy shared by a team is evaluated once for each robot. A network with recurrent layers has
/// a memory for each robot of each Simulation, which is empty at the beginning of an episode.
class NetworkPolicy : public Policy {
 public:
  /// @param path  policy.h5, a checkpoint folder or a training run's folder (see find_policy)
  /// @throws Error as find_policy(), LocatedError as read_policy()
  explicit NetworkPolicy(const std::filesystem::path& path);
  explicit NetworkPolicy(PolicyFile policy);

  /// The content of the policy file.
  const PolicyFile& policy() const { return network_.policy(); }
  /// The path of the policy file.
  const std::filesystem::path& file() const { return file_; }

  std::string check_fits(const CompiledScenario& compiled) const override;

  /// Does not allocate. If the observation contains a NaN, so do the actions.
  /// A recurrent network keeps a memory of these calls since reset().
  /// @param observation  observation_size values
  /// @param action  action_size values in [-1, 1]
  /// @param images  one for each of policy().images
  void act(std::span<const float> observation, std::span<float> action,
           std::span<const ImageView> images = {});
  /// Allocates only in the first call with a simulation, and only for recurrent networks.
  void act(const Simulation& simulation, std::span<float> action) override;
  /// Clears the memory of act(observation, action).
  void reset();

 private:
  /// States of the recurrent layers, of one robot after another.
  struct Memory {
    const Simulation* simulation = nullptr;
    std::vector<float> states;
  };
  Memory& memory_of(const Simulation& simulation);
  void act(std::span<const float> observation, std::span<const ImageView> images, Memory& memory,
           std::span<float> action);

  std::filesystem::path file_;
  NetworkEvaluator network_;
  std::vector<ImageView> views_;  ///< of a simulation's images
  Memory own_;                    ///< without a simulation
  std::vector<Memory> memories_;  ///< one per simulation
};

}  // namespace skybody
