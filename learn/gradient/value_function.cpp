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
    : critic_({observed, hyper.hidden, 1, hyper.activation}, hyper.max_grad_norm, best_isa()),
      delayed_(critic_.parameters().size()),
      scale_(scale_of(hyper)) {
  critic_.initialize(kLastLayerGain, seed, derive_stream("learn.value"));
  std::copy_n(parameters().data(), delayed_.size(), delayed_.data());
  prepare();
}

double ValueFunction::scale_of(const Hyperparameters& hyper) {
  return 1.0 / std::max(1.0 - hyper.discount, kLeastRest);
}

void ValueFunction::follow() {
  for (std::size_t k = 0; k < delayed_.size(); ++k) {
    delayed_[k] = std::fma(kFollow, parameters()[k] - delayed_[k], delayed_[k]);
  }
  prepare();
}

void ValueFunction::prepare() { network().transpose(target_parameters(), delayed_transposed_); }

}  // namespace skybody::learn
