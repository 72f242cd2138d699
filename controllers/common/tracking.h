// Attitude error and feed-forward for the attitude loop of a trajectory-following controller: the
// rotation to the desired attitude, and the desired rates and angular acceleration.
//
// The desired attitude R_d follows from the desired specific thrust; its rates w_d and their
// derivative from the reference's jerk and snap (flatness.h). In axes of B, with R_e = R^T R_d:
//   rates         R_e w_d
//   acceleration  R_e dw_d/dt - w x (R_e w_d)        the derivative of the above
// The part of w_d due to the controller's own feedback is left out: it would need the body's
// acceleration, which is not measured.
//
// Source: T. Lee, M. Leok and N. H. McClamroch, Geometric tracking control of a quadrotor UAV on
// SE(3), CDC 2010, eq. 10, 11 and 16.
#pragma once

#include "controllers/common/attitude_error.h"
#include "controllers/common/flatness.h"

namespace skybody::control {

template <class Real>
struct Tracking {
  Vec3<Real> error;         ///< remaining rotation, axes of B [rad]
  Vec3<Real> rates;         ///< desired rates, B axes [rad/s]
  Vec3<Real> acceleration;  ///< desired acceleration, B axes [rad/s^2]; only if requested
};

/// @param thrust             desired specific thrust, W axes [m/s^2]
/// @param with_acceleration  false: leave the acceleration at 0
template <class Real>
SKYBODY_INLINE Tracking<Real> tracking(AttitudeError form, const BodyMotion<Real>& base,
                                       const Vec3<Real>& thrust,
                                       const ReferencePoint<Real>& reference,
                                       bool with_acceleration) {
  const auto flat = flat_attitude(thrust, reference.yaw);
  const auto flown = flat_rates(flat, reference.jerk, reference.yaw_rate);
  const Quat<Real> left = conjugate(base.rotation) * flat.rotation;
  Tracking<Real> out;
  out.error = attitude_error(form, left);
  out.rates = rotate(left, flown.value);
  out.acceleration = {Real(0.0), Real(0.0), Real(0.0)};
  if (with_acceleration) {
    const Vec3<Real> change =
        flat_acceleration(flat, flown, reference.jerk, reference.snap, reference.yaw_rate);
    out.acceleration = rotate(left, change) - cross(base.angular_velocity, out.rates);
  }
  return out;
}

/// Torque for an angular acceleration of a body of nominal inertia.
class AngularAccelerationToTorque {
 public:
  void configure(const BodyInfo& base) {
    inertia_ = inertia_of(base);
    is_diagonal_ = inertia_.xy == 0.0 && inertia_.xz == 0.0 && inertia_.yz == 0.0;
  }

  /// J dw/dt + w x J w, B axes [N m].
  template <class Real>
  SKYBODY_INLINE Vec3<Real> operator()(const Vec3<Real>& w, const Vec3<Real>& acceleration) const {
    return times(acceleration) + cross(w, times(w));
  }

 private:
  template <class Real>
  SKYBODY_INLINE Vec3<Real> times(const Vec3<Real>& v) const {
    const SymMat3<double>& j = inertia_;
    if (is_diagonal_) return {v.x * j.xx, v.y * j.yy, v.z * j.zz};  // most vehicles
    return lift<Real>(j) * v;
  }

  SymMat3<double> inertia_{};
  bool is_diagonal_ = false;
};

}  // namespace skybody::control
