// policy.h5: a trained network as Python writes it and C++ flies it. docs/policies.md has the
// format.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skybody {

/// What follows a layer's sums.
enum class Activation { kNone, kTanh, kRelu, kElu };
/// In their order.
inline constexpr const char* kActivationNames[] = {"none", "tanh", "relu", "elu"};
inline const char* name(Activation activation) {
  return kActivationNames[static_cast<int>(activation)];
}

/// The activation of that name; none: there is none.
inline std::optional<Activation> find_activation(std::string_view word) {
  for (std::size_t k = 0; k < std::size(kActivationNames); ++k) {
    if (word == kActivationNames[k]) return static_cast<Activation>(k);
  }
  return std::nullopt;
}

enum class LayerKind { kDense, kGru };
/// In their order.
inline constexpr const char* kLayerKindNames[] = {"dense", "gru"};
inline const char* name(LayerKind kind) { return kLayerKindNames[static_cast<int>(kind)]; }

/// Dense: y = activation(weight x + bias).
/// Gated recurrent units (Cho et al. 2014), as PyTorch's GRU: with the state h, and rows of weights
/// and biases for the gates r, z and n in this order,
///   r = sigmoid(weight x + bias + state_weight h + state_bias), z likewise,
///   n = tanh(weight x + bias + r (state_weight h + state_bias)),  y = h' = (1 - z) n + z h.
struct PolicyLayer {
  int inputs = 0, outputs = 0;
  std::vector<double> weight;  ///< weight_rows() x inputs, row by row
  std::vector<double> bias;    ///< weight_rows()
  Activation activation = Activation::kNone;
  LayerKind kind = LayerKind::kDense;
  std::vector<double> state_weight;  ///< weight_rows() x outputs; dense: empty
  std::vector<double> state_bias;    ///< weight_rows(); dense: empty

  int weight_rows() const { return kind == LayerKind::kGru ? 3 * outputs : outputs; }
};

/// How the last layer's values become actions in [-1, 1].
enum class ActionSquash { kClip, kTanh };

/// A robot's part of a team's rows: which entries of the observation the network sees for it, and
/// which entries of the action the network's outputs are.
struct PolicyAgent {
  std::vector<int> observation, action;
};

/// That a policy.h5 may have.
inline constexpr int kMostLayers = 64;

/// Everything in a policy.h5, checked: sizes fit together and every number is finite.
struct PolicyFile {
  std::string scenario;                       ///< its name
  std::string scenario_hash;                  ///< 16 hexadecimal digits; empty: unknown
  std::string algorithm;                      ///< that trained it
  std::int64_t steps = 0;                     ///< environment steps trained
  int observation_size = 0, action_size = 0;  ///< of the scenario's rows
  /// Empty: the network sees whole rows and gives whole rows. Else it is evaluated once for each of
  /// these, and each entry of the action is one agent's.
  std::vector<PolicyAgent> agents;
  ActionSquash squash = ActionSquash::kClip;
  /// Empty, or one value per input: x = clip((observation - mean) * scale, -clip, clip). Scales
  /// are above zero.
  std::vector<double> mean, scale;
  double clip = 0.0;
  std::vector<PolicyLayer> layers;  ///< 1 ... kMostLayers

  /// Of the network.
  int input_size() const {
    return agents.empty() ? observation_size : static_cast<int>(agents[0].observation.size());
  }
  int output_size() const {
    return agents.empty() ? action_size : static_cast<int>(agents[0].action.size());
  }
};

/// Why a policy whose sizes fit together is none that a learner makes; empty: it is one.
std::string fault_of(const PolicyFile& policy);

/// @throws LocatedError with the file's name: missing, no policy, damaged, another version, sizes
///         that do not fit together, values that are not finite, fault_of()
PolicyFile read_policy(const std::filesystem::path& file);

/// The policy file that a path means: a file itself, a checkpoint folder's policy.h5, or that of a
/// run folder's newest checkpoint (checkpoints/step_NNNNNNNNNNNN).
/// @throws Error if there is none
std::filesystem::path find_policy(const std::filesystem::path& path);

}  // namespace skybody
