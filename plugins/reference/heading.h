// The heading along a path.
#pragma once

#include "plugins/reference/path_jet.h"

namespace skybody::reference {

/// If the horizontal part of dp/ds [m/s] is shorter than this, the path has no direction.
inline constexpr double kLeastSlope = 1e-6;

/// Direction of a path in the horizontal plane [rad], and its rate by path time. It is the
/// direction of dp/ds, which is defined even where the pace ds/dt is zero. Where the path stands
/// still or goes straight up: `instead`.
/// @param point  by path time, with at least one derivative; the rate takes two
template <class Real, int N>
SKYBODY_INLINE Jet<Real, N> direction(const Vec3<Jet<Real, N>>& point, const Real& instead) {
  const Real x = point.x.derivative(1), y = point.y.derivative(1);
  const Real square = x * x + y * y;
  const auto usable = square > kLeastSlope * kLeastSlope;
  Jet<Real, N> yaw(0.0);
  yaw.c[0] = select(usable, atan2(y, x), instead);
  if constexpr (N > 2) {
    const Real turn = x * point.y.derivative(2) - y * point.x.derivative(2);
    yaw.c[1] = select(usable, turn / select(usable, square, Real(1.0)), Real(0.0));
  }
  return yaw;
}

}  // namespace skybody::reference
