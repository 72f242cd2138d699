// policy.h5: a trained network, written by Python and evaluated by C++. docs/policies.md has the
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

/// The activation function of a layer.
enum class Activation { kNone, kTanh, kRelu, kElu };
/// In the order of Activation.
inline constexpr const char* kActivationNames[] = {"none", "tanh", "relu", "elu"};
inline const char* name(Activation activation) {
  return kActivationNames[static_cast<int>(activation)];
}

/// The activation of that name, or nullopt.
inline std::optional<Activation> find_activation(std::string_view word) {
  for (std::size_t k = 0; k < std::size(kActivationNames); ++k) {
    if (word == kActivationNames[k]) return static_cast<Activation>(k);
  }
  return std::nullopt;
}

enum class LayerKind { kDense, kGru, kConv, kLstm };
/// In the order of LayerKind.
inline constexpr const char* kLayerKindNames[] = {"dense", "gru", "conv", "lstm"};
inline const char* name(LayerKind kind) { return kLayerKindNames[static_cast<int>(kind)]; }

/// Sizes of a convolution of images of height x width pixels with some channels.
struct ConvShape {
  int height = 0, width = 0, channels = 0;  ///< of the input
  int outputs = 0;                          ///< channels of the output
  int kernel_height = 0, kernel_width = 0;
  int stride = 1;
  /// Zeros around the image, so that the output has ceil(size / stride) rows and columns: on either
  /// side half of them, the odd one at the end. False: windows are inside of the image only.
  bool same = false;

  int out_height() const { return windows(height, kernel_height); }
  int out_width() const { return windows(width, kernel_width); }
  /// Values of a window.
  int window_size() const { return kernel_height * kernel_width * channels; }
  int output_size() const { return out_height() * out_width() * outputs; }
  bool operator==(const ConvShape&) const = default;

 private:
  int windows(int size, int kernel) const {
    return same ? (size + stride - 1) / stride : (size - kernel) / stride + 1;
  }
};

/// Dense: y = activation(weight x + bias).
/// Convolution: the same for every window of an image, with x = the window's values, row by row,
///   pixel by pixel, channel by channel. Outputs have the same order.
/// Gated recurrent unit (Cho et al. 2014), as PyTorch's GRU: with the state h, and rows of weights
/// and biases for the gates r, z and n in this order,
///   r = sigmoid(weight x + bias + state_weight h + state_bias), z with its own rows,
///   n = tanh(weight x + bias + r (state_weight h + state_bias)),  y = h' = (1 - z) n + z h.
/// Long short-term memory (Gers et al. 1999), as PyTorch's LSTM: with the states h and c, and rows
/// of the gates i, f, g and o in this order, each weight x + bias + state_weight h + state_bias,
///   c' = sigmoid(f) c + sigmoid(i) tanh(g),  y = h' = sigmoid(o) tanh(c').
struct PolicyLayer {
  int inputs = 0, outputs = 0;  ///< of a convolution: of one window
  std::vector<double> weight;   ///< weight_rows() x inputs, row by row
  std::vector<double> bias;     ///< weight_rows()
  Activation activation = Activation::kNone;
  LayerKind kind = LayerKind::kDense;
  std::vector<double> state_weight;  ///< weight_rows() x outputs; dense: empty
  std::vector<double> state_bias;    ///< weight_rows(); dense: empty
  ConvShape conv;                    ///< of a convolution

  /// Rows of weights for each output.
  int gates() const { return kind == LayerKind::kGru ? 3 : kind == LayerKind::kLstm ? 4 : 1; }
  int weight_rows() const { return gates() * outputs; }
  bool is_recurrent() const { return gates() > 1; }
  /// State values of one robot: h, of long short-term memory then c.
  int state_size() const {
    return kind == LayerKind::kGru ? outputs : kind == LayerKind::kLstm ? 2 * outputs : 0;
  }
};

/// The map from the last layer's values to actions in [-1, 1].
enum class ActionSquash { kClip, kTanh };

/// One robot's part of a team's rows: the entries of the observation that are the network's inputs,
/// and the entries of the action that are its outputs.
struct PolicyAgent {
  std::vector<int> observation, action;
};

/// An image that the policy sees, and the network that makes features of it.
struct PolicyImage {
  std::string column;  ///< name of the observation's column
  int height = 0, width = 0, channels = 0;
  double low = 0.0, high = 1.0;     ///< pixels become (clip(pixel, low, high) - low) / (high - low)
  std::vector<PolicyLayer> layers;  ///< convolutions; the last one has a single window

  int features() const { return layers.empty() ? 0 : layers.back().outputs; }
};

/// Largest number of layers in a policy.h5.
inline constexpr int kMostLayers = 64;

/// The contents of a policy.h5, checked: sizes are consistent and every number is finite.
struct PolicyFile {
  std::string scenario;                       ///< its name
  std::string scenario_hash;                  ///< 16 hexadecimal digits; empty: unknown
  std::string algorithm;                      ///< the training algorithm
  std::int64_t steps = 0;                     ///< environment steps trained
  int observation_size = 0, action_size = 0;  ///< of the scenario's rows
  /// Empty: the network's inputs and outputs are whole rows. Else the network is evaluated once per
  /// agent, and each entry of the action belongs to one agent.
  std::vector<PolicyAgent> agents;
  ActionSquash squash = ActionSquash::kClip;
  /// Empty, or one value per input: x = clip((observation - mean) * scale, -clip, clip). Scales
  /// are above zero.
  std::vector<double> mean, scale;
  double clip = 0.0;
  /// The network's inputs are followed by the features of these images.
  std::vector<PolicyImage> images;
  std::vector<PolicyLayer> layers;  ///< 1 ... kMostLayers

  /// Number of the network's inputs that are observations.
  int input_size() const {
    return agents.empty() ? observation_size : static_cast<int>(agents[0].observation.size());
  }
  int feature_size() const {
    int size = 0;
    for (const PolicyImage& image : images) size += image.features();
    return size;
  }
  int output_size() const {
    return agents.empty() ? action_size : static_cast<int>(agents[0].action.size());
  }
};

/// The invalid value of a policy with consistent sizes, for messages; empty: all are valid.
std::string fault_of(const PolicyFile& policy);

/// @throws LocatedError with the file's name if it is missing, not a policy, damaged, of another
///         version, has inconsistent sizes or values that are not finite, or for fault_of()
PolicyFile read_policy(const std::filesystem::path& file);

/// The policy file of a path: the file itself, the policy.h5 of a checkpoint folder, or the
/// policy.h5 of the newest checkpoint of a run folder (checkpoints/step_NNNNNNNNNNNN).
/// @throws Error if there is none
std::filesystem::path find_policy(const std::filesystem::path& path);

}  // namespace skybody
