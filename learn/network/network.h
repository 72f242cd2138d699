// A network of dense layers on rows of floats: what it computes and the gradient of that.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/base/isa.h"
#include "core/io/policy_file.h"

namespace skybody::learn {

/// Sizes of a network; every hidden layer has the same activation, the last has none.
struct NetworkShape {
  int inputs = 0;
  std::vector<int> hidden;
  int outputs = 0;
  Activation activation = Activation::kTanh;
};

/// Memory that forward() fills and backward() reads: the layers' outputs for some rows.
/// One for each thread; forward() makes it as large as it needs, so that only the first call
/// allocates.
struct NetworkMemory {
  std::vector<AlignedArray<float>> outputs;       ///< of each layer, rows x padded size
  AlignedArray<float> gradient, gradient_before;  ///< at a layer's output and at its input
  int rows = 0;
};

/// Weights that a step of the optimiser has changed, in the order in which backward() reads them.
struct TransposedWeights {
  std::vector<AlignedArray<float>> layers;
};

/// A multilayer perceptron. Holds no parameters: these are an array of floats of the caller's, so
/// that optimisers, sums of gradients and checkpoints are loops over floats.
///
/// Layer after layer: the weight, `inputs` rows of `outputs` padded to a multiple of kPad with
/// zeros that stay zero, then the bias, padded likewise. Sums go over inputs in order, with fused
/// multiply-add; sums over rows of a gradient go in order of the rows. So the bits are the same on
/// v3 and v4, and for any split of rows into calls.
class Network {
 public:
  static constexpr int kPad = 16;  ///< floats

  /// @param isa  that the processor has, such as best_isa()
  Network(const NetworkShape& shape, Isa isa);

  const NetworkShape& shape() const;
  /// Floats of the parameters, padding counted.
  std::size_t parameter_count() const;
  /// Orthogonal weights with gain sqrt(2), in the last layer `last_gain`; zero biases.
  /// @param key,stream  of core/base/random.h
  void initialize(std::span<float> parameters, double last_gain, std::uint64_t key,
                  std::uint64_t stream) const;
  /// Brings `transposed` up to date. After every change of the parameters, before backward().
  void transpose(std::span<const float> parameters, TransposedWeights& transposed) const;

  /// Outputs of `rows` rows.
  /// @param x    row r at x + r * x_stride, `inputs` wide   @param y  row r at y + r * y_stride,
  /// `outputs` wide
  void forward(std::span<const float> parameters, const float* x, int x_stride, int rows,
               NetworkMemory& memory, float* y, int y_stride) const;
  /// Adds to `gradient` what follows from the gradient at the outputs of the rows that forward()
  /// was called with last.
  /// @param dy  row r at dy + r * dy_stride   @param dx  null, or where the gradient at the inputs
  /// goes
  void backward(std::span<const float> parameters, const TransposedWeights& transposed,
                const float* x, int x_stride, NetworkMemory& memory, const float* dy, int dy_stride,
                std::span<float> gradient, float* dx = nullptr, int dx_stride = 0) const;
  /// As layers of a policy file.
  std::vector<PolicyLayer> layers(std::span<const float> parameters) const;
};

}  // namespace skybody::learn
