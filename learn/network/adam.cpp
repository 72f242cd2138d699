#include "learn/network/adam.h"

#include <algorithm>
#include <string>

#include "core/base/error.h"
#include "core/base/math.h"
#include "learn/network/kernels/kernels.h"

namespace skybody::learn {
namespace {

/// base^exponent by squaring: a function of the step alone, with the same bits everywhere.
double power(double base, std::int64_t exponent) {
  double result = 1.0;
  for (double square = base; exponent > 0; exponent >>= 1, square *= square) {
    if ((exponent & 1) != 0) result *= square;
  }
  return result;
}

}  // namespace

Adam::Adam(std::size_t count, Isa isa, const AdamSettings& settings)
    : kernels_(&kernels_of(isa)), settings_(settings), first_(count), second_(count) {}

void Adam::step(std::span<const float> gradient, double learning_rate, double scale,
                std::span<float> parameters) {
  ++steps_;
  const double first_unbias = 1.0 / (1.0 - power(settings_.first_decay, steps_));
  const double second_unbias = 1.0 / (1.0 - power(settings_.second_decay, steps_));
  const AdamScalars scalars = {
      .gradient_scale = static_cast<float>(scale),
      .first_rest = static_cast<float>(1.0 - settings_.first_decay),
      .second_decay = static_cast<float>(settings_.second_decay),
      .second_rest = static_cast<float>(1.0 - settings_.second_decay),
      .rate = static_cast<float>(learning_rate * first_unbias),
      .second_unbias = static_cast<float>(sqrt(second_unbias)),
      .epsilon = static_cast<float>(settings_.epsilon),
  };
  kernels_->adam(scalars, gradient.data(), first_.data(), second_.data(), parameters.data(),
                 first_.size());
}

void Adam::restore(std::int64_t steps, std::span<const float> first,
                   std::span<const float> second) {
  if (steps < 0 || first.size() != first_.size() || second.size() != second_.size()) {
    throw Error("the optimiser's state has " + std::to_string(steps) + " steps and " +
                std::to_string(first.size()) + " and " + std::to_string(second.size()) +
                " moments; needed: " + std::to_string(first_.size()) + " of each");
  }
  steps_ = steps;
  std::copy(first.begin(), first.end(), first_.data());
  std::copy(second.begin(), second.end(), second_.data());
}

double gradient_norm(std::span<const float> gradient, Isa isa) {
  return sqrt(kernels_of(isa).square_sum(gradient.data(), gradient.size()));
}

double clip_scale(double norm, double largest) { return std::min(1.0, largest / (norm + 1e-6)); }

void add_to(std::span<const float> addend, std::span<float> sum, Isa isa) {
  kernels_of(isa).add(addend.data(), sum.data(), sum.size());
}

}  // namespace skybody::learn
