// The optimiser: sums the slices' gradients, bounds the norm, and makes a step.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "core/base/simd/aligned_array.h"
#include "core/base/simd/isa.h"

namespace skybody::learn {

struct KernelTable;

/// Adam (Kingma and Ba 2015, arXiv 1412.6980, algorithm 1) in float32, as PyTorch computes it. Step
/// t, with beta1 = 0.9, beta2 = 0.999 and epsilon = 1e-5:
///   m += (1 - beta1) (g - m),  v = beta2 v + (1 - beta2) g^2,
///   parameter -= rate / (1 - beta1^t) * m / (sqrt(v) / sqrt(1 - beta2^t) + epsilon).
/// Epsilon is larger than the paper's 1e-8, so that steps shrink as gradients vanish. The bits are
/// the same on v3 and v4.
class Adam {
 public:
  /// @param size           number of parameters
  /// @param max_grad_norm  gradients are scaled down to this Euclidean norm, as by PyTorch's
  ///        clip_grad_norm_; 0: no bound
  /// @param isa            an instruction set of the processor, such as best_isa()
  Adam(std::size_t size, double max_grad_norm, Isa isa);

  std::size_t size() const { return gradient_.size(); }
  /// The gradient for step().
  std::span<float> gradient() { return {gradient_.data(), gradient_.size()}; }

  /// Sets gradient() to the sum, in the order given, of at least one gradient.
  void sum(std::span<const float* const> gradients);
  /// One step. @returns the gradient's norm before it was bounded; if it is not finite, nothing has
  /// changed
  double step(std::span<float> parameters, double learning_rate);

  /// Passes the checkpointed arrays to `visitor`. @param self  const or not
  template <class Self, class Visitor>
  static void visit(Self& self, const std::string& name, Visitor& visitor) {
    visitor(name + ".first", self.first_.data(), self.first_.size());
    visitor(name + ".second", self.second_.data(), self.second_.size());
    visitor(name + ".powers", self.powers_, 2);
  }

 private:
  const KernelTable* kernels_;
  double max_grad_norm_;
  AlignedArray<float> gradient_, first_, second_;
  double powers_[2] = {1.0, 1.0};  ///< powers of both betas by the number of completed steps
};

}  // namespace skybody::learn
