// Functions of attitude for observations and rewards.
#pragma once

#include <skybody/plugin.h>

namespace skybody::task_kit {

/// Angle between the body's and the world's z axis, 0 .. pi [rad].
template <class Real>
SKYBODY_INLINE Real tilt(const Quat<Real>& q) {
  return acos(max(tilt_cosine(q), Real(-1.0)));  // round-off can give less than -1
}

/// The same rotation with w >= 0.
template <class Real>
SKYBODY_INLINE Quat<Real> canonical(const Quat<Real>& q) {
  const Quat<Real> opposite{-q.w, -q.x, -q.y, -q.z};
  return select(q.w < 0.0, opposite, q);
}

}  // namespace skybody::task_kit
