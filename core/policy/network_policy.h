// Flies trained policies: networks read from policy.h5.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/env/column_type.h"
#include "core/io/files/policy_file.h"
#include "core/policy/image_features.h"
#include "core/policy/layer_weights.h"
#include "core/policy/policy.h"

namespace skybody {

/// An image in memory: height x width x channels values of a type.
struct ImageView {
  ColumnType type = ColumnType::kUint8;
  const std::uint8_t* pixels = nullptr;
};

/// The deterministic policy: the mean of the action distribution. Evaluated in float by
/// network_layers.h, whose bits are the same on every machine: also those of the C sources that
/// `skybody export` writes. A policy shared by a team is evaluated once for each robot. A network
/// with recurrent layers has a memory for each robot of each Simulation, which is empty at the
/// beginning of an episode.
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
  void prepare();
  Memory& memory_of(const Simulation& simulation);
  void act(std::span<const float> observation, std::span<const ImageView> images, Memory& memory,
           std::span<float> action);
  void act(const PolicyAgent& agent, std::span<const float> observation, float* states,
           std::span<float> action);
  void evaluate(std::size_t layer, float* state);

  std::filesystem::path file_;
  PolicyFile policy_;
  PolicyAgent all_;  ///< of a policy without agents
  NormalizationWeights normalization_;
  std::vector<LayerWeights> weights_;          ///< of each layer
  std::vector<float> values_, next_;           ///< between two layers, as wide as the widest
  int state_size_ = 0;                         ///< of all recurrent layers, for one robot
  std::vector<float> sums_;                    ///< of a recurrent layer
  std::vector<ImageFeatures> image_features_;  ///< of each image
  std::vector<ImageView> views_;               ///< of a simulation's images
  std::vector<float> features_;                ///< of all images
  Memory own_;                                 ///< without a simulation
  std::vector<Memory> memories_;               ///< one per simulation
};

}  // namespace skybody
