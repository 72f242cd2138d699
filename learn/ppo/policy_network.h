// The network of a policy, with or without a memory.
#pragma once

#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "learn/hyperparameters.h"
#include "learn/network/network.h"
#include "learn/network/recurrent_network.h"

namespace skybody::learn {

/// Rows of a policy, with its memory at their beginning. Without a memory only the number of rows
/// is used.
struct PolicySteps {
  Sequences sequences;                   ///< without memory: of one step each
  const std::uint8_t* begins = nullptr;  ///< for each row: whether an episode begins
  float* states = nullptr;               ///< for each sequence: input, then output
};

/// Dense layers, after a layer of gated recurrent units if `recurrent_units` is not 0. The
/// functions are those of Network and RecurrentNetwork.
class PolicyNetwork {
 public:
  struct Memory {
    NetworkActivations dense;
    RecurrentActivations recurrent;
  };
  struct Transposed {
    TransposedWeights dense;
    TransposedRecurrent recurrent;
  };

  PolicyNetwork(int inputs, int outputs, const Hyperparameters& hyper, Isa isa);

  /// 0 units without a memory.
  const RecurrentShape& shape() const { return shape_; }
  std::size_t parameter_count() const;
  void initialize(std::span<float> parameters, double last_gain, std::uint64_t key,
                  std::uint64_t stream) const;
  void transpose(std::span<const float> parameters, Transposed& transposed) const;
  void forward(std::span<const float> parameters, const float* x, int x_stride,
               const PolicySteps& steps, Memory& memory, float* y, int y_stride) const;
  void backward(const Transposed& transposed, const float* x, int x_stride,
                const PolicySteps& steps, Memory& memory, const float* dy, int dy_stride,
                std::span<float> gradient) const;
  std::vector<PolicyLayer> layers(std::span<const float> parameters) const;

 private:
  RecurrentShape shape_;
  std::variant<Network, RecurrentNetwork> network_;
};

}  // namespace skybody::learn
