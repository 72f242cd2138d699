// Flies trained policies: networks read from policy.h5.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/env/column_type.h"
#include "core/io/files/policy_file.h"
#include "core/policy/image_features.h"
#include "core/policy/policy.h"

namespace skybody {

/// An image in memory: height x width x channels values of a type.
struct ImageView {
  ColumnType type = ColumnType::kUint8;
  const std::uint8_t* pixels = nullptr;
};

/// The deterministic policy: the mean of the action distribution. Evaluated in double with sums
/// from left to right and bit-stable functions: equal observations give equal actions on every
/// machine, within 1e-6 of the training library's result in float. A policy shared by a team is
/// evaluated once for each robot. A network with recurrent layers has a memory for each robot of
/// each Simulation, which is empty at the beginning of an episode.
class NetworkPolicy : public Policy {
 public:
  /// @param path  policy.h5, a checkpoint folder or a training run's folder (see find_policy)
  /// @throws Error as find_policy() and read_policy()
  explicit NetworkPolicy(const std::filesystem::path& path);
  explicit NetworkPolicy(PolicyFile policy);

  /// The content of the policy file.
  const PolicyFile& policy() const { return policy_; }
  /// The path of the policy file.
  const std::filesystem::path& file() const { return file_; }

  std::string check_fits(const CompiledScenario& compiled) const override;

  /// Does not allocate. If the observation contains a value that is not finite, so do the actions.
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
    std::vector<double> states;
  };
  void prepare();
  Memory& memory_of(const Simulation& simulation);
  void act(std::span<const float> observation, std::span<const ImageView> images, Memory& memory,
           std::span<float> action);
  void act(const PolicyAgent& agent, std::span<const float> observation, double* states,
           std::span<float> action);
  void advance(const PolicyLayer& layer, double* state);

  std::filesystem::path file_;
  PolicyFile policy_;
  PolicyAgent all_;                              ///< of a policy without agents
  std::vector<double> values_, next_;            ///< between two layers, as wide as the widest
  int state_size_ = 0;                           ///< of all recurrent layers, for one robot
  std::vector<double> from_input_, from_state_;  ///< a recurrent layer's sums
  std::vector<ImageFeatures> image_features_;    ///< of each image
  std::vector<ImageView> views_;                 ///< of a simulation's images
  std::vector<double> features_;                 ///< of all images
  Memory own_;                                   ///< without a simulation
  std::vector<Memory> memories_;                 ///< one per simulation
};

}  // namespace skybody
