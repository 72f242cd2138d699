// The optimiser, and the norm that gradients are cut to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/aligned_array.h"
#include "core/base/isa.h"

namespace skybody::learn {

struct KernelTable;

struct AdamSettings {
  double first_decay = 0.9;     ///< beta1
  double second_decay = 0.999;  ///< beta2
  double epsilon = 1e-5;
};

/// Adam (Kingma and Ba, ICLR 2015, algorithm 1), as PyTorch computes it: of step t
///   m += (1 - beta1) (g - m),  v = beta2 v + (1 - beta2) g^2,
///   parameter -= rate / (1 - beta1^t) * m / (sqrt(v) / sqrt(1 - beta2^t) + epsilon).
/// The bits are the same on v3 and v4.
class Adam {
 public:
  /// @param count  of parameters   @param isa  that the processor has
  Adam(std::size_t count, Isa isa, const AdamSettings& settings = {});

  /// @param gradient       `count` values   @param parameters  `count` values, changed
  /// @param learning_rate  of this step     @param scale  of the gradient, see clip_scale()
  void step(std::span<const float> gradient, double learning_rate, double scale,
            std::span<float> parameters);

  /// What a checkpoint holds.
  std::int64_t steps() const { return steps_; }
  std::span<const float> first() const { return {first_.data(), first_.size()}; }
  std::span<const float> second() const { return {second_.data(), second_.size()}; }
  /// @throws Error if there are not `count` moments of each, or `steps` < 0
  void restore(std::int64_t steps, std::span<const float> first, std::span<const float> second);

 private:
  const KernelTable* kernels_;
  AdamSettings settings_;
  AlignedArray<float> first_, second_;  ///< moments m and v
  std::int64_t steps_ = 0;
};

/// The Euclidean norm, summed in a fixed order: 1024 floats at a time, these sums in double.
double gradient_norm(std::span<const float> gradient, Isa isa);

/// What a gradient of this norm is multiplied with so that it has at most `largest`, as PyTorch's
/// clip_grad_norm_: min(1, largest / (norm + 1e-6)).
double clip_scale(double norm, double largest);

/// sum += addend, of equal length: as gradients of slices are added, in their order.
void add_to(std::span<const float> addend, std::span<float> sum, Isa isa);

}  // namespace skybody::learn
