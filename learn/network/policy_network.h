// The network of a policy or of a value function, with or without images and a memory.
#pragma once

#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "learn/hyperparameters.h"
#include "learn/network/image_encoder.h"
#include "learn/network/image_rows.h"
#include "learn/network/network.h"
#include "learn/network/recurrent_network.h"

namespace skybody::learn {

/// Rows of a policy, with its memory at their beginning. Without a memory only the number of rows
/// is used.
struct PolicySteps {
  Sequences sequences;                   ///< without memory: of one step each
  const std::uint8_t* begins = nullptr;  ///< for each row: whether an episode begins
  float* states = nullptr;               ///< for each sequence: input, then output
  ImageRows images = {};                 ///< if there are any
};

/// Inputs of a network.
struct NetworkInputs {
  int values = 0;                   ///< of a row
  std::vector<ImageFormat> images;  ///< each with an ImageEncoder
};

/// The sizes of the networks of images.
EncoderShape encoder_shape(const Hyperparameters& hyper);

/// Dense layers, after a layer of gated recurrent units if `units` is not 0. Features of images are
/// inputs behind the row's values. The functions are those of Network and RecurrentNetwork.
/// Parameters are those of the encoders, then those of the network.
class PolicyNetwork {
 public:
  struct Memory {
    NetworkActivations dense;
    RecurrentActivations recurrent;
    std::vector<EncoderActivations> encoders;
    AlignedArray<float> inputs, d_inputs;  ///< rows of values and features, only with images
  };
  struct Transposed {
    TransposedWeights dense;
    TransposedRecurrent recurrent;
    std::vector<TransposedEncoder> encoders;
  };

  /// @param units  of the memory; 0: none
  PolicyNetwork(const NetworkInputs& inputs, int outputs, const Hyperparameters& hyper, int units,
                Isa isa);

  /// 0 units without a memory.
  const RecurrentShape& shape() const { return shape_; }
  std::size_t parameter_count() const;
  void initialize(std::span<float> parameters, double last_gain, std::uint64_t key,
                  std::uint64_t stream) const;
  void transpose(std::span<const float> parameters, Transposed& transposed) const;
  void forward(std::span<const float> parameters, const float* x, int x_stride,
               const PolicySteps& steps, Memory& memory, float* y, int y_stride) const;
  /// @param dx  null, or output: the gradient at the row's values. Pixels have none
  void backward(const Transposed& transposed, const float* x, int x_stride,
                const PolicySteps& steps, Memory& memory, const float* dy, int dy_stride,
                std::span<float> gradient, float* dx = nullptr, int dx_stride = 0) const;
  /// Converts to layers of a policy file: those behind the images, and those of each image.
  std::vector<PolicyLayer> layers(std::span<const float> parameters) const;
  std::vector<std::vector<PolicyLayer>> image_layers(std::span<const float> parameters) const;

 private:
  /// Rows of the network's inputs.
  struct Rows {
    const float* x;
    int stride;
  };
  std::size_t network_at() const { return begins_.back(); }
  Rows add_features(std::span<const float> parameters, const Rows& values, int rows,
                    const ImageRows& images, Memory& memory) const;

  int values_;
  std::vector<ImageEncoder> encoders_;
  std::vector<std::size_t> begins_;  ///< of each encoder's parameters, then of the network's
  RecurrentShape shape_;
  int input_stride_;  ///< of rows with features
  std::variant<Network, RecurrentNetwork> network_;
};

}  // namespace skybody::learn
