// The course of a training: how far it is, and the step size there.
#pragma once

#include <algorithm>
#include <cstdint>

#include "learn/hyperparameters.h"

namespace skybody::learn {

/// The share of a training that is done, 0 to 1. @param total_steps  0: it has no end, so none is
inline double progress(std::int64_t steps, std::int64_t total_steps) {
  if (total_steps <= 0) return 0.0;
  return std::min(1.0, static_cast<double>(steps) / static_cast<double>(total_steps));
}

/// Of Adam for the policy: linear from `learning_rate` to its share `final_learning_rate`. The
/// value function's stays at the first: one that lags behind the policy misleads it.
/// @param progress  0 to 1
inline double learning_rate(const Hyperparameters& hyper, double progress) {
  return hyper.learning_rate * (1.0 - progress * (1.0 - hyper.final_learning_rate));
}

}  // namespace skybody::learn
