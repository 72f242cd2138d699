#include "learn/ppo/adam.h"

#include <cmath>

#include "core/base/error.h"
#include "core/base/kernels.h"
#include "core/base/lanes.h"

namespace skybody::learn {
namespace {

constexpr double kFirstDecay = 0.9, kSecondDecay = 0.999;
constexpr float kEpsilon = 1e-5f;
constexpr std::size_t kLanes = 16;

// Inner loops over 16 values, whatever the processor's vectors: each value or partial sum has a
// lane of its own, so that all widths give the same bits.

struct Sum {
  template <int W>
  static SKYBODY_INLINE void run(const float* const* from, std::size_t parts, std::size_t size,
                                 float* __restrict to) {
    for (std::size_t i = 0; i < size; i += kLanes) {
      float sum[kLanes];
      for (std::size_t l = 0; l < kLanes; ++l) sum[l] = from[0][i + l];
      for (std::size_t p = 1; p < parts; ++p) {
        for (std::size_t l = 0; l < kLanes; ++l) sum[l] += from[p][i + l];
      }
      for (std::size_t l = 0; l < kLanes; ++l) to[i + l] = sum[l];
    }
  }
};

struct SquaredNorm {
  template <int W>
  static SKYBODY_INLINE double run(const float* values, std::size_t size) {
    double sum[kLanes] = {};
    for (std::size_t i = 0; i < size; i += kLanes) {
      for (std::size_t l = 0; l < kLanes; ++l) {
        const double x = static_cast<double>(values[i + l]);
        sum[l] += x * x;
      }
    }
    double all = 0.0;
    for (std::size_t l = 0; l < kLanes; ++l) all += sum[l];
    return all;
  }
};

struct StepTerms {
  float scale;          ///< of the gradient
  float rate;           ///< learning rate over 1 - beta1^t
  float second_scale;   ///< 1 / sqrt(1 - beta2^t)
  float first, second;  ///< 1 - beta
};

struct Step {
  template <int W>
  static SKYBODY_INLINE void run(const StepTerms* terms, std::size_t size,
                                 const float* __restrict gradient, float* __restrict first,
                                 float* __restrict second, float* __restrict parameters) {
    const StepTerms t = *terms;
    for (std::size_t i = 0; i < size; ++i) {
      const float g = gradient[i] * t.scale;
      first[i] += t.first * (g - first[i]);
      second[i] += t.second * (g * g - second[i]);
      parameters[i] -= t.rate * first[i] / (std::sqrt(second[i]) * t.second_scale + kEpsilon);
    }
  }
};

}  // namespace

Adam::Adam(std::size_t size, double max_grad_norm, Isa isa)
    : isa_(isa), max_grad_norm_(max_grad_norm), gradient_(size), first_(size), second_(size) {
  SKYBODY_DEMAND(size % kLanes == 0, "parameters are padded");
}

void Adam::sum(std::span<const float* const> gradients) {
  kernel<Sum>(isa_)(gradients.data(), gradients.size(), size(), gradient_.data());
}

double Adam::step(std::span<float> parameters, double learning_rate) {
  SKYBODY_DEMAND(parameters.size() == size(), "as many parameters as gradients");
  const double norm = std::sqrt(kernel<SquaredNorm>(isa_)(gradient_.data(), size()));
  if (!std::isfinite(norm)) return norm;
  powers_[0] *= kFirstDecay;
  powers_[1] *= kSecondDecay;
  const bool is_too_long = max_grad_norm_ > 0.0 && norm > max_grad_norm_;
  const StepTerms terms{static_cast<float>(is_too_long ? max_grad_norm_ / (norm + 1e-6) : 1.0),
                        static_cast<float>(learning_rate / (1.0 - powers_[0])),
                        static_cast<float>(1.0 / std::sqrt(1.0 - powers_[1])),
                        static_cast<float>(1.0 - kFirstDecay),
                        static_cast<float>(1.0 - kSecondDecay)};
  kernel<Step>(isa_)(&terms, size(), gradient_.data(), first_.data(), second_.data(),
                     parameters.data());
  return norm;
}

}  // namespace skybody::learn
