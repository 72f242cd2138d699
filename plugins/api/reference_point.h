// A point of a reference: one element of the signal `trajectory`.
#pragma once

#include "core/base/math/vec3.h"
#include "core/plugin_abi/signals.h"
#include "plugins/api/values.h"

namespace skybody {

/// Desired motion of a robot's base at one time. W axes.
template <class Real>
struct ReferencePoint {
  Vec3<Real> position;      ///< [m]
  Vec3<Real> velocity;      ///< [m/s]
  Vec3<Real> acceleration;  ///< [m/s^2]
  Vec3<Real> jerk;          ///< [m/s^3]
  Vec3<Real> snap;          ///< [m/s^4]
  Real yaw;                 ///< heading [rad]
  Real yaw_rate;            ///< [rad/s]
};

/// Number of values in a ReferencePoint. Signal `trajectory` has one or several points.
inline constexpr int kReferencePointSize = SKYBODY_REFERENCE_VALUES;

/// Point `index` of a `trajectory`.
template <class Real>
ReferencePoint<Real> reference_point(const ConstValues<Real>& values, int index = 0) {
  const int k = kReferencePointSize * index;
  return {values.vec3(k),      values.vec3(k + 3), values.vec3(k + 6), values.vec3(k + 9),
          values.vec3(k + 12), values[k + 15],     values[k + 16]};
}

/// Writes point `index` of a `trajectory`.
template <class Real>
void set_reference_point(const Values<Real>& values, const ReferencePoint<Real>& point,
                         int index = 0) {
  const int k = kReferencePointSize * index;
  values.set(k, point.position);
  values.set(k + 3, point.velocity);
  values.set(k + 6, point.acceleration);
  values.set(k + 9, point.jerk);
  values.set(k + 12, point.snap);
  values.set(k + 15, point.yaw);
  values.set(k + 16, point.yaw_rate);
}

}  // namespace skybody
