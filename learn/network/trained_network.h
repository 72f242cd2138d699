// A network with its parameters and their optimiser.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <type_traits>

#include "core/base/simd/aligned_array.h"
#include "learn/network/adam.h"
#include "learn/network/network.h"

namespace skybody::learn {

/// A Network, its parameters and Adam. Passes of one thread use forward(), backward() and step();
/// passes of several threads use network() with parameters(), transposed(), and activations and a
/// gradient of each thread.
class TrainedNetwork {
 public:
  /// Parameters are zero until initialize().
  /// @param max_grad_norm  larger gradients are scaled down to this norm; 0: no bound
  /// @throws Error as Network
  explicit TrainedNetwork(const NetworkShape& shape, double max_grad_norm = 0.0,
                          Isa isa = best_isa());

  /// @param last_gain    of the weights of the last layer
  /// @param key, stream  of the random numbers
  void initialize(double last_gain, std::uint64_t key, std::uint64_t stream);

  const Network& network() const { return network_; }
  std::span<const float> parameters() const { return {parameters_.data(), parameters_.size()}; }
  const TransposedWeights& transposed() const { return transposed_; }

  /// Computes the outputs of some rows.
  /// @param x  row r at x + r * x_stride, `inputs` wide
  /// @param y  rows x outputs, without gaps
  void forward(const float* x, int x_stride, int rows, float* y);
  /// Adds the gradient of a loss to that of the next step().
  /// @param x   as passed to the last forward()
  /// @param dy  gradient at its outputs, rows x outputs
  /// @param dx  null, or output: the gradient at the inputs, with x_stride
  void backward(const float* x, int x_stride, const float* dy, float* dx = nullptr);
  /// One step of Adam down the gradient, which is then zero again.
  /// @returns the gradient's norm; if it is not finite, no parameter has changed
  double step(double learning_rate);
  /// One step down a sum of gradients, added in the order given.
  double step(std::span<const float* const> gradients, double learning_rate);

  /// Passes the checkpointed arrays to `visitor` (state_blocks.h), and prepares computations with
  /// the values that it has written. @param self  const or not
  template <class Self, class Visitor>
  static void visit(Self& self, const std::string& name, Visitor& visitor) {
    visitor(name, self.parameters_.data(), self.parameters_.size());
    Adam::visit(self.adam_, name + ".adam", visitor);
    if constexpr (!std::is_const_v<Self>) self.prepare();
  }

 private:
  void prepare() { network_.transpose(parameters(), transposed_); }
  double step_and_prepare(double learning_rate);

  Network network_;
  AlignedArray<float> parameters_;
  TransposedWeights transposed_;
  Adam adam_;
  NetworkActivations activations_;
};

}  // namespace skybody::learn
