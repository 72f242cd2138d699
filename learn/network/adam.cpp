#include "learn/network/adam.h"

#include <algorithm>
#include <cmath>

#include "core/base/math/math.h"
#include "core/base/system/error.h"
#include "learn/network/kernels/kernels.h"

namespace skybody::learn {
namespace {

constexpr double kFirstDecay = 0.9, kSecondDecay = 0.999, kEpsilon = 1e-5;
constexpr std::size_t kBlock = 2048;

}  // namespace

Adam::Adam(std::size_t size, double max_grad_norm, Isa isa)
    : kernels_(&kernels_of(isa)),
      max_grad_norm_(max_grad_norm),
      gradient_(size),
      first_(size),
      second_(size) {}

void Adam::sum(std::span<const float* const> gradients) {
  // In blocks, so that the sum stays in the L1 cache.
  for (std::size_t at = 0; at < size(); at += kBlock) {
    const std::size_t count = std::min(kBlock, size() - at);
    std::copy_n(gradients[0] + at, count, gradient_.data() + at);
    for (const float* gradient : gradients.subspan(1)) {
      kernels_->add(gradient + at, gradient_.data() + at, count);
    }
  }
}

double Adam::step(std::span<float> parameters, double learning_rate) {
  SKYBODY_DEMAND(parameters.size() == size(), "as many parameters as gradients");
  const double norm = sqrt(kernels_->square_sum(gradient_.data(), size()));
  if (!std::isfinite(norm)) return norm;
  powers_[0] *= kFirstDecay;
  powers_[1] *= kSecondDecay;
  const bool is_bounded = max_grad_norm_ > 0.0;
  const AdamScalars scalars = {
      .gradient_scale =
          static_cast<float>(is_bounded ? std::min(1.0, max_grad_norm_ / (norm + 1e-6)) : 1.0),
      .first_rest = static_cast<float>(1.0 - kFirstDecay),
      .second_decay = static_cast<float>(kSecondDecay),
      .second_rest = static_cast<float>(1.0 - kSecondDecay),
      .rate = static_cast<float>(learning_rate / (1.0 - powers_[0])),
      .second_unbias = static_cast<float>(1.0 / sqrt(1.0 - powers_[1])),
      .epsilon = static_cast<float>(kEpsilon),
  };
  kernels_->adam(scalars, gradient_.data(), first_.data(), second_.data(), parameters.data(),
                 size());
  return norm;
}

}  // namespace skybody::learn
