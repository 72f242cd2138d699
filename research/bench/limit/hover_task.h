// The hover task on one quadrotor.
#pragma once

#include "research/bench/limit/block_step.h"
#include "research/bench/limit/flight_ends.h"
#include "research/bench/limit/free_flight.h"

namespace skybody::bench::limit {

/// Indices of the values of an environment.
enum HoverValue { kTarget = kFlyerValues, kTargetYaw = kTarget + 3, kHoverValues };

/// Begins the next episode of one environment: initial state and target drawn as in
/// scenarios/hover/hover.yaml, rotors at hover speed. Not inlined: it is rare, and the same code
/// for all widths.
/// @param values  its first value; consecutive values are `stride` doubles apart
void begin_hover(double* values, int stride, std::uint64_t env, std::uint64_t episode);

template <class R>
struct HoverTask {
  using Real = R;
  static constexpr int kState = kFlyerValues, kValues = kHoverValues;
  static constexpr int kOwnObservation = 14, kObservation = 22;
  static constexpr double kHorizon = 20000.0;
  static constexpr double kSpeedScale = 1150.0;  ///< rotor speed per (action + 1) [rad/s]
  static constexpr auto begin_episode = &begin_hover;

  SKYBODY_INLINE Real& value(int k) { return flyer_value(flyer, k); }
  SKYBODY_INLINE void fly(const Real* command) { limit::fly(flyer, command); }

  /// @param get  value k of the environments
  template <class Get>
  SKYBODY_INLINE Outcome<Real> observe(Get&& get, Real (&values)[kOwnObservation]) const {
    const Quat<Real>& q = flyer.rotation;
    const Vec3<Real>&p = flyer.position, v = flyer.velocity, w = flyer.spin;
    const Vec3<Real> error = Vec3<Real>{get(kTarget), get(kTarget + 1), get(kTarget + 2)} - p;
    const Heading<Real> heading = heading_of(q);
    const auto left = heading.cosine <= Real(0.0);
    Real yaw = atan2_right(heading.sine, heading.cosine);
    Real yaw_error = get(kTargetYaw) - yaw;
    if (bits(left) != 0) [[unlikely]] {  // a heading beyond 90 degrees: full atan2
      yaw = pick(left, full_atan2(heading.sine, heading.cosine), yaw);
      yaw_error = wrapped(get(kTargetYaw) - yaw);
    }
    const Quat<Real> attitude = upright(q);
    const Real own[kOwnObservation] = {error.x,    error.y, error.z,    yaw_error,  v.x,
                                       v.y,        v.z,     attitude.w, attitude.x, attitude.y,
                                       attitude.z, w.x,     w.y,        w.z};
    for (int k = 0; k < kOwnObservation; ++k) values[k] = own[k];
    // 1 / (1 + 2.56 |e|^2) + 0.01 / (1 + |w|^2) with one division.
    const Real near = 1.0 + 2.56 * (squared_norm(error) + yaw_error * yaw_error);
    const Real calm = 1.0 + squared_norm(w);
    return {(calm + 0.01 * near) / (near * calm),
            larger(tilted_or_far(q, p), magnitude(yaw) - kYawMax)};
  }

  Flyer<Real> flyer;
};

}  // namespace skybody::bench::limit
