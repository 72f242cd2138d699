// The optimiser: slices' gradients become one, of bounded norm, and a step.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "core/base/aligned_array.h"
#include "core/base/isa.h"

namespace skybody::learn {

struct KernelTable;

/// Adam (Kingma and Ba 2015, arXiv 1412.6980, algorithm 1) in float32, as PyTorch computes it. Of
/// step t, with beta1 = 0.9, beta2 = 0.999 and epsilon = 1e-5:
///   m += (1 - beta1) (g - m),  v = beta2 v + (1 - beta2) g^2,
///   parameter -= rate / (1 - beta1^t) * m / (sqrt(v) / sqrt(1 - beta2^t) + epsilon).
/// With a larger epsilon than the paper's 1e-8, steps shrink with gradients that vanish. The bits
/// are the same on v3 and v4.
class Adam {
 public:
  /// @param size           of the parameters
  /// @param max_grad_norm  gradients are scaled down to this Euclidean norm, as PyTorch's
  ///                       clip_grad_norm_ does; 0: they are not
  /// @param isa            that the processor has, such as best_isa()
  Adam(std::size_t size, double max_grad_norm, Isa isa);

  std::size_t size() const { return gradient_.size(); }
  /// The gradient that step() takes.
  std::span<float> gradient() { return {gradient_.data(), gradient_.size()}; }

  /// gradient() becomes the sum, in the order given, of at least one gradient.
  void sum(std::span<const float* const> gradients);
  /// One step. @returns the gradient's norm before it was bounded; where it is not finite, nothing
  /// was changed
  double step(std::span<float> parameters, double learning_rate);

  /// Names to `visitor` what a checkpoint holds. @param self  const or not
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
  double powers_[2] = {1.0, 1.0};  ///< of both betas, to the number of steps done
};

}  // namespace skybody::learn
