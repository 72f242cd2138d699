// Evaluates the network of a policy file, for the engine and for the program onboard.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/env/column_type.h"
#include "core/io/files/policy_file.h"
#include "core/policy/image_features.h"
#include "core/policy/layer_weights.h"

namespace skybody {

/// An image in memory: height x width x channels values of a type.
struct ImageView {
  ColumnType type = ColumnType::kUint8;
  const std::uint8_t* pixels = nullptr;
};

/// A network in float, by network_layers.h. Its bits are the same on every machine: also those of
/// the C sources that `skybody export` writes. The memory of recurrent layers is the caller's.
class NetworkEvaluator {
 public:
  NetworkEvaluator() = default;
  explicit NetworkEvaluator(PolicyFile policy);

  const PolicyFile& policy() const { return policy_; }
  /// Values of the recurrent layers' memory of one robot; all zero at the beginning of an episode.
  int state_size() const { return state_size_; }
  /// The robots that the network serves, each by an evaluation: those of the file, or one robot
  /// with all of a row.
  const std::vector<PolicyAgent>& agents() const { return agents_; }

  /// Computes the features of images, which all evaluations use until the next call. Does not
  /// allocate. @param images  one for each of policy().images
  void see(std::span<const ImageView> images);
  /// Does not allocate. If the observation contains a NaN, so do the outputs.
  /// @param observation  row of the scenario: observation_size values
  /// @param states  state_size() values of the robot, advanced by this call
  /// @returns one value for each of agent.action, before they are clipped to [-1, 1]; valid until
  ///   the next call
  std::span<const float> evaluate(const PolicyAgent& agent, std::span<const float> observation,
                                  float* states);

 private:
  void evaluate(std::size_t layer, float* state);

  PolicyFile policy_;
  std::vector<PolicyAgent> agents_;
  NormalizationWeights normalization_;
  std::vector<LayerWeights> weights_;          ///< of each layer
  std::vector<float> values_, next_;           ///< between two layers, as wide as the widest
  int state_size_ = 0;                         ///< of all recurrent layers, for one robot
  std::vector<float> sums_;                    ///< of a recurrent layer
  std::vector<ImageFeatures> image_features_;  ///< of each image
  std::vector<float> features_;                ///< of all images
};

}  // namespace skybody
