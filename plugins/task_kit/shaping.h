// Terms of rewards.
#pragma once

#include <skybody/plugin.h>

namespace skybody::task_kit {

/// 1 / (1 + weight x): 1 at x = 0, with a slope that does not vanish there.
template <class Real>
SKYBODY_INLINE Real closeness(const Real& x, double weight) {
  return 1.0 / (1.0 + weight * x);
}

/// 1 at the goal, 0 from `range` on, linear in between: a slope far from the goal.
template <class Real>
SKYBODY_INLINE Real approach(const Real& distance, double range) {
  return max(Real(0.0), 1.0 - distance / range);
}

/// Cost of tilt: 1 / max(cos tilt, least) - 1. A wall whose slope acts before a limit of the tilt
/// ends the episode.
template <class Real>
SKYBODY_INLINE Real tilt_wall(const Quat<Real>& rotation, double least_cosine) {
  return 1.0 / max(tilt_cosine(rotation), Real(least_cosine)) - 1.0;
}

/// Decrease of a distance since the last step [m]. The sum telescopes: it rewards the progress made
/// and no detour (Ng, Harada and Russell 1999, potential-based shaping with a discount of 1). Keep
/// `before` in the task's State; at a reset the gain is 0.
template <class Real>
SKYBODY_INLINE Real progress(const EnvView<Real>& env, const Real& distance, Real& before) {
  const auto stepped = env.step() > Word<Real>(0);
  const Real gain = choose(stepped, before - distance, Real(0.0));
  before = distance;
  return gain;
}

}  // namespace skybody::task_kit
