// Failure conditions of a flight, as in the shipped tasks, by comparisons only.
#pragma once

#include "core/base/math/quat.h"
#include "research/bench/limit/lane_choice.h"

namespace skybody::bench::limit {

constexpr double kYawMax = 1.57, kYawTangent = 1255.7655915007897;  ///< [rad], and its tangent
constexpr double kTiltCosine = 7.963267107332633e-4;                ///< of 1.57 rad
constexpr double kBound = 7.0;                                      ///< [m]

/// The body's x axis seen from above, scaled by the pitch's cosine.
template <class Real>
struct Heading {
  Real sine, cosine;
};
template <class Real>
SKYBODY_INLINE Heading<Real> heading_of(const Quat<Real>& q) {
  return {2.0 * (q.x * q.y + q.w * q.z), 1.0 - 2.0 * (q.y * q.y + q.z * q.z)};
}

/// > 0 if the tilt is too large or the vehicle has left the box.
template <class Real>
SKYBODY_INLINE Real tilted_or_far(const Quat<Real>& q, const Vec3<Real>& p) {
  const Real far = larger(larger(magnitude(p.x), magnitude(p.y)), magnitude(p.z));
  return larger(kTiltCosine - (1.0 - 2.0 * (q.x * q.x + q.y * q.y)), far - kBound);
}

/// > 0 if the heading is beyond kYawMax.
template <class Real>
SKYBODY_INLINE Real turned_too_far(const Heading<Real>& heading) {
  return magnitude(heading.sine) - kYawTangent * heading.cosine;
}

/// The same rotation with w >= 0.
template <class Real>
SKYBODY_INLINE Quat<Real> upright(const Quat<Real>& q) {
  const auto round = q.w < Real(0.0);
  return {pick(round, -q.w, q.w), pick(round, -q.x, q.x), pick(round, -q.y, q.y),
          pick(round, -q.z, q.z)};
}

}  // namespace skybody::bench::limit
