// A network of dense layers on rows of floats: what it computes and the gradient of that.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/base/isa.h"
#include "core/io/policy_file.h"
#include "learn/network/panel_matrix.h"

namespace skybody::learn {

struct KernelTable;

/// Sizes of a network; every hidden layer has the same activation, the last has none.
struct NetworkShape {
  int inputs = 0;
  std::vector<int> hidden;
  int outputs = 0;
  Activation activation = Activation::kTanh;
};

/// Memory that forward() fills and backward() reads: the layers' outputs for some rows.
/// One for each thread; forward() and backward() make it as large as they need, so that only calls
/// with more rows than any before allocate.
struct NetworkActivations {
  std::vector<AlignedArray<float>> outputs;       ///< of each layer, rows x its stride
  AlignedArray<float> gradient, gradient_before;  ///< at a layer's output and at its input
  int rows = 0;                                   ///< of the last forward()
};

/// Weights that a step of the optimiser has changed, in the order in which backward() reads them.
struct TransposedWeights {
  std::vector<AlignedArray<float>> layers;
};

/// A multilayer perceptron. Holds no parameters: these are an array of floats of the caller's, so
/// that optimisers, sums of gradients and checkpoints are loops over floats.
///
/// Layer after layer: the weight, inputs x outputs as PanelMatrix lays it out, then the bias,
/// padded likewise. Padding is zero and stays zero, as its gradient is. Sums go over inputs in
/// order, with fused multiply-add; sums over rows of a gradient go in order of the rows. So the
/// bits are the same on v3 and v4, and for any split of rows into calls.
class Network {
 public:
  /// The parameters are a multiple of this many floats.
  static constexpr int kPad = learn::kPad;

  /// @param isa  that the processor has, such as best_isa()
  /// @throws Error if a size is not in 1..2^24, or the activation of hidden layers is none
  Network(const NetworkShape& shape, Isa isa);

  const NetworkShape& shape() const { return shape_; }
  /// Floats of the parameters, padding counted; a multiple of kPad.
  std::size_t parameter_count() const { return parameter_count_; }
  /// Orthogonal weights with gain sqrt(2), in the last layer `last_gain`; zero biases (Saxe et al.,
  /// ICLR 2014). Where a layer has more outputs than inputs, columns are orthogonal, else rows.
  /// @param key,stream  of core/base/random.h
  void initialize(std::span<float> parameters, double last_gain, std::uint64_t key,
                  std::uint64_t stream) const;
  /// Brings `transposed` up to date. After every change of the parameters, before backward().
  void transpose(std::span<const float> parameters, TransposedWeights& transposed) const;

  /// Outputs of `rows` rows.
  /// @param x    row r at x + r * x_stride, `inputs` wide   @param y  row r at y + r * y_stride,
  /// `outputs` wide
  void forward(std::span<const float> parameters, const float* x, int x_stride, int rows,
               NetworkActivations& memory, float* y, int y_stride) const;
  /// Adds to `gradient` what follows from the gradient at the outputs of the rows that forward()
  /// was called with last.
  /// @param x   as given to forward()
  /// @param dy  row r at dy + r * dy_stride   @param dx  null, or where the gradient at the inputs
  /// goes
  void backward(const TransposedWeights& transposed, const float* x, int x_stride,
                NetworkActivations& memory, const float* dy, int dy_stride,
                std::span<float> gradient, float* dx = nullptr, int dx_stride = 0) const;

  /// As layers of a policy file.
  std::vector<PolicyLayer> layers(std::span<const float> parameters) const;
  /// The reverse: parameters from a policy file's layers, rounded to float.
  /// @throws Error if the layers are not of this shape
  void set_layers(std::span<const PolicyLayer> layers, std::span<float> parameters) const;

 private:
  struct Layer {
    PanelMatrix weight;              ///< inputs x outputs
    std::size_t weight_at, bias_at;  ///< in the parameters
    int stride;                      ///< of rows of outputs
    Activation activation;
  };
  /// Rows of an array.
  struct Rows {
    const float* data;
    int stride;
  };
  void add_layer(int inputs, int outputs, Activation activation);
  Rows input_of(std::size_t layer, const Rows& x, const NetworkActivations& memory) const;
  void forward_rows(std::span<const float> parameters, const Rows& x, int first, int rows,
                    NetworkActivations& memory) const;
  void backward_rows(const TransposedWeights& transposed, const Rows& x, int first, int rows,
                     NetworkActivations& memory, std::span<float> gradient, float* dx,
                     int dx_stride) const;
  void propagate(const TransposedWeights& transposed, std::size_t layer, int first, int rows,
                 NetworkActivations& memory) const;
  int widest_stride() const;

  NetworkShape shape_;
  const KernelTable* kernels_;
  std::vector<Layer> layers_;
  std::size_t parameter_count_ = 0;
  int chunk_ = 0;  ///< rows that go through all layers at a time
};

}  // namespace skybody::learn
