#include "learn/gradient/value_function.h"

#include <algorithm>
#include <cmath>

#include "core/base/math/random.h"

namespace skybody::learn {
namespace {

constexpr double kLastLayerGain = 0.01;  // unknown states start with a value near 0
/// Fraction of the distance to the critic that the delayed copy moves per iteration (arXiv
/// 2204.07137, table 3: 0.2 to 0.8 of the copy stay).
constexpr float kFollow = 0.4f;
constexpr double kLeastRest = 1e-3;  // lower bound of 1 - discount, as a scale of values

}  // namespace

void td_lambda(std::span<const double> gains, std::span<const double> values, double discount,
               double lambda, std::span<double> targets) {
  double next = values.empty() ? 0.0 : values.back();
  for (std::size_t t = gains.size(); t-- > 0;) {
    next = gains[t] + discount * ((1.0 - lambda) * values[t] + lambda * next);
    targets[t] = next;
  }
}

ValueFunction::ValueFunction(int observed, const Hyperparameters& hyper, std::uint64_t seed)
    : network_({observed, hyper.hidden, 1, hyper.activation}, best_isa()),
      parameters_(network_.parameter_count()),
      delayed_(network_.parameter_count()),
      adam_(network_.parameter_count(), hyper.max_grad_norm, best_isa()),
      scale_(scale_of(hyper)) {
  network_.initialize({parameters_.data(), parameters_.size()}, kLastLayerGain, seed,
                      derive_stream("learn.value"));
  std::copy_n(parameters_.data(), parameters_.size(), delayed_.data());
  prepare();
}

double ValueFunction::scale_of(const Hyperparameters& hyper) {
  return 1.0 / std::max(1.0 - hyper.discount, kLeastRest);
}

double ValueFunction::step(std::span<const float* const> gradients, double learning_rate) {
  adam_.sum(gradients);
  const double norm = adam_.step({parameters_.data(), parameters_.size()}, learning_rate);
  network_.transpose(parameters(), transposed_);
  return norm;
}

void ValueFunction::follow() {
  for (std::size_t k = 0; k < parameters_.size(); ++k) {
    delayed_[k] = std::fma(kFollow, parameters_[k] - delayed_[k], delayed_[k]);
  }
  network_.transpose(target_parameters(), delayed_transposed_);
}

void ValueFunction::prepare() {
  network_.transpose(parameters(), transposed_);
  network_.transpose(target_parameters(), delayed_transposed_);
}

}  // namespace skybody::learn
