// A network of dense layers on rows of floats: forward pass and gradient.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "core/base/simd/isa.h"
#include "core/io/files/policy_file.h"
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

/// Memory that forward() fills and backward() reads: the layers' outputs for some rows. One per
/// thread. forward() and backward() enlarge it as needed, so that only a call with more rows than
/// all before allocates.
struct NetworkActivations {
  std::vector<AlignedArray<float>> outputs;       ///< of each layer, rows x its stride
  AlignedArray<float> gradient, gradient_before;  ///< at a layer's output and at its input
  int rows = 0;                                   ///< of the last forward()
};

/// Transposed weights in the order in which backward() reads them.
struct TransposedWeights {
  std::vector<AlignedArray<float>> layers;
};

/// A multilayer perceptron. It holds no parameters: these are an array of floats of the caller, so
/// that optimisers, sums of gradients and checkpoints are loops over floats.
///
/// Parameters, layer by layer: the weight, inputs x outputs in the layout of PanelMatrix, then the
/// bias, padded likewise. Padding and its gradient are and stay zero. Sums run over inputs in
/// order, with fused multiply-add; sums of a gradient run over rows in order. So the bits are the
/// same on v3 and v4, and for any split of rows into calls.
class Network {
 public:
  /// The number of parameters is a multiple of this.
  static constexpr int kPad = learn::kPad;

  /// @param isa  an instruction set of the processor, such as best_isa()
  /// @throws Error if a size is not in 1..2^24, or the activation of hidden layers is none
  Network(const NetworkShape& shape, Isa isa);

  const NetworkShape& shape() const { return shape_; }
  /// Floats of the parameters, including padding; a multiple of kPad.
  std::size_t parameter_count() const { return parameter_count_; }
  /// Orthogonal weights with gain sqrt(2), in the last layer `last_gain`; zero biases (Saxe et al.,
  /// ICLR 2014). If a layer has more outputs than inputs, columns are orthogonal, otherwise rows.
  /// @param key,stream  of core/base/math/random.h
  void initialize(std::span<float> parameters, double last_gain, std::uint64_t key,
                  std::uint64_t stream) const;
  /// Updates `transposed`. Call it after every change of the parameters, before backward().
  void transpose(std::span<const float> parameters, TransposedWeights& transposed) const;

  /// Computes the outputs of `rows` rows.
  /// @param x    row r at x + r * x_stride, `inputs` wide
  /// @param y    row r at y + r * y_stride, `outputs` wide
  void forward(std::span<const float> parameters, const float* x, int x_stride, int rows,
               NetworkActivations& memory, float* y, int y_stride) const;
  /// Adds to `gradient` the gradient by the parameters, from the gradient `dy` at the outputs of
  /// the last forward().
  /// @param x   as passed to forward()
  /// @param dy  row r at dy + r * dy_stride
  /// @param dx  null, or output: the gradient at the inputs
  void backward(const TransposedWeights& transposed, const float* x, int x_stride,
                NetworkActivations& memory, const float* dy, int dy_stride,
                std::span<float> gradient, float* dx = nullptr, int dx_stride = 0) const;

  /// Converts to layers of a policy file.
  std::vector<PolicyLayer> layers(std::span<const float> parameters) const;
  /// Sets parameters from a policy file's layers, rounded to float.
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
  int chunk_ = 0;  ///< rows that go through all layers at once
};

}  // namespace skybody::learn
