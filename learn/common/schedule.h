// Progress of a training and its current step size.
#pragma once

#include <algorithm>
#include <cstdint>

#include "learn/hyperparameters.h"

namespace skybody::learn {

/// The completed fraction of a training, 0 to 1. @param total_steps  0: unlimited, the fraction is
/// 0
inline double progress(std::int64_t steps, std::int64_t total_steps) {
  if (total_steps <= 0) return 0.0;
  return std::min(1.0, static_cast<double>(steps) / static_cast<double>(total_steps));
}

/// Step size of Adam for the policy: linear from `learning_rate` to `final_learning_rate` times
/// that. The value function keeps the initial step size: if it lagged behind the policy, it would
/// mislead it.
/// @param progress  0 to 1
inline double learning_rate(const Hyperparameters& hyper, double progress) {
  return hyper.learning_rate * (1.0 - progress * (1.0 - hyper.final_learning_rate));
}

}  // namespace skybody::learn
