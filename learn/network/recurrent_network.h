// A network with memory: gated recurrent units, then dense layers on their states.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "learn/network/gru.h"
#include "learn/network/network.h"

namespace skybody::learn {

struct RecurrentShape {
  int inputs = 0;
  int units = 0;            ///< of the recurrent layer, the first one
  std::vector<int> hidden;  ///< of the dense layers after it
  int outputs = 0;
  Activation activation = Activation::kTanh;  ///< of the hidden dense layers
};

/// Memory of both parts, one per thread.
struct RecurrentActivations {
  GruActivations gru;
  NetworkActivations head;
  AlignedArray<float> d_states;  ///< gradient at the head's inputs
};

struct TransposedRecurrent {
  TransposedGru gru;
  TransposedWeights head;
};

/// A Gru with a Network on its states. Its parameters are those of the Gru, then those of the
/// Network. Its results are reproducible to the same extent.
class RecurrentNetwork {
 public:
  /// @throws Error as Gru and Network
  RecurrentNetwork(const RecurrentShape& shape, Isa isa);

  const RecurrentShape& shape() const { return shape_; }
  std::size_t parameter_count() const { return gru_.parameter_count() + head_.parameter_count(); }
  /// Floats of a sequence's state, including padding: zeros at the beginning of an episode.
  int state_stride() const { return gru_.state_stride(); }
  /// As Gru::initialize() and Network::initialize().
  void initialize(std::span<float> parameters, double last_gain, std::uint64_t key,
                  std::uint64_t stream) const;
  /// Updates `transposed`. Call it after every change of the parameters, before backward().
  void transpose(std::span<const float> parameters, TransposedRecurrent& transposed) const;

  /// Computes the outputs of every step of some sequences. One step of several environments is a
  /// set of sequences of one step. Rows are those of Sequences.
  /// @param states,begins  as for Gru::forward()
  /// @param y              row r at y + r * y_stride, `outputs` wide
  void forward(std::span<const float> parameters, const float* x, int x_stride,
               const Sequences& sequences, const std::uint8_t* begins, float* states,
               RecurrentActivations& memory, float* y, int y_stride) const;
  /// Adds to `gradient` the gradient by the parameters, from the gradient `dy` at the outputs of
  /// the last forward().
  /// @param dy  row r at dy + r * dy_stride
  /// @param dx  null, or output: the gradient at the inputs
  void backward(const TransposedRecurrent& transposed, const float* x, int x_stride,
                const std::uint8_t* begins, RecurrentActivations& memory, const float* dy,
                int dy_stride, std::span<float> gradient, float* dx = nullptr,
                int dx_stride = 0) const;

  /// Converts to layers of a policy file.
  std::vector<PolicyLayer> layers(std::span<const float> parameters) const;
  /// Converts from layers of a policy file. @throws Error if the layers are not of this shape
  void set_layers(std::span<const PolicyLayer> layers, std::span<float> parameters) const;

 private:
  RecurrentShape shape_;
  Gru gru_;
  Network head_;
};

}  // namespace skybody::learn
