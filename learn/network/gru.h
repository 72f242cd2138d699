// A layer of gated recurrent units: forward pass over sequences, and gradient.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/simd/aligned_array.h"
#include "core/base/simd/isa.h"
#include "core/io/files/policy_file.h"
#include "learn/network/panel_matrix.h"

namespace skybody::learn {

struct KernelTable;

/// Rows of several sequences of equal length: step t of sequence s is row s * steps + t.
struct Sequences {
  int count = 0, steps = 0;

  int rows() const { return count * steps; }
};

/// Memory that forward() fills and backward() reads. One per thread. Only a call with more rows
/// than all before allocates.
struct GruActivations {
  AlignedArray<float> outputs;  ///< the states after each step, rows x Gru::state_stride()
  AlignedArray<float> before;   ///< the states before each step
  AlignedArray<float> from_input, from_state, gates;  ///< rows x 3 * Gru::state_stride()
  AlignedArray<float> d_input, d_state;
  AlignedArray<float> d_next, d_before;  ///< of one step of all sequences
  AlignedArray<float> d_x;
  Sequences sequences;  ///< of the last forward()
};

struct TransposedGru {
  AlignedArray<float> input, state;
};

/// Gated recurrent units (Cho et al. 2014, arXiv 1406.1078) as PyTorch's GRU computes them, with
/// the reset gate after the product:
///   r = sigmoid(W_ir x + b_ir + W_hr h + b_hr),  z = sigmoid(W_iz x + b_iz + W_hz h + b_hz),
///   n = tanh(W_in x + b_in + r (W_hn h + b_hn)),  h' = (1 - z) n + z h.
///
/// The parameters are one array of the caller: inputs x 3 units of W_i in the layout of PanelMatrix
/// (r, z, n, each padded to a multiple of kPad), b_i, units x 3 units of W_h, b_h. The gradient is
/// summed over rows in the order of Sequences. So the bits are the same on v3 and v4 and for any
/// split of the sequences into calls.
class Gru {
 public:
  /// @throws Error if a size is not in 1..2^20
  Gru(int inputs, int units, Isa isa);

  int inputs() const { return inputs_; }
  int units() const { return units_; }
  /// Floats of a state, including padding, which is and stays zero.
  int state_stride() const { return padded_; }
  std::size_t parameter_count() const { return parameter_count_; }
  /// Orthogonal weights of every gate, zero biases.
  /// @param key,stream  of core/base/math/random.h
  void initialize(std::span<float> parameters, std::uint64_t key, std::uint64_t stream) const;
  /// Updates `transposed`. Call it after every change of the parameters, before backward().
  void transpose(std::span<const float> parameters, TransposedGru& transposed) const;

  /// Computes the states after each step, in memory.outputs.
  /// @param x       row r at x + r * x_stride, `inputs` wide
  /// @param states  count x state_stride(): at the beginning, then at the end
  /// @param begins  null, or one value per row: not 0 if an episode begins, so that the state
  ///        before this step is zero
  void forward(std::span<const float> parameters, const float* x, int x_stride,
               const Sequences& sequences, const std::uint8_t* begins, float* states,
               GruActivations& memory) const;
  /// Backpropagation through time. Adds to `gradient` the gradient by the parameters, from the
  /// gradient `dy` at the outputs of the last forward(). Initial states count as constants.
  /// @param x,begins  as passed to forward()
  /// @param dy        row r at dy + r * dy_stride, `units` wide
  /// @param dx        null, or output: the gradient at the inputs
  void backward(const TransposedGru& transposed, const float* x, int x_stride,
                const std::uint8_t* begins, GruActivations& memory, const float* dy, int dy_stride,
                std::span<float> gradient, float* dx = nullptr, int dx_stride = 0) const;

  /// Converts to a layer of a policy file.
  PolicyLayer layer(std::span<const float> parameters) const;
  /// Converts from a layer of a policy file. @throws Error if the layer is not of this shape
  void set_layer(const PolicyLayer& layer, std::span<float> parameters) const;

 private:
  void make_room(GruActivations& memory) const;
  void begin_step(const Sequences& sequences, int step, const std::uint8_t* begins,
                  const float* states, GruActivations& memory) const;
  void forward_step(std::span<const float> parameters, const Sequences& sequences, int step,
                    GruActivations& memory) const;
  void backward_step(const TransposedGru& transposed, int step, const std::uint8_t* begins,
                     const float* dy, int dy_stride, GruActivations& memory) const;

  int inputs_, units_, padded_;
  const KernelTable* kernels_;
  PanelMatrix input_weight_, state_weight_;
  std::size_t input_bias_at_, state_weight_at_, state_bias_at_, parameter_count_;
};

}  // namespace skybody::learn
