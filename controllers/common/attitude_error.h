// Attitude error: the rotation from a body's attitude to the desired one, as a vector in body axes
// [rad]. Three forms, equal for small angles.
//
// With q_e = conj(q) q_d = (w, v) the remaining rotation, in axes of B:
//   quaternion     2 sgn(w) v        largest at half a turn; takes the shorter way round
//   se3            2 w v = vee(R^T R_d - R_d^T R) / 2 = -e_R of Lee: weak near half a turn
//   tilt_priority  q_e = q_tilt q_yaw: first the shortest rotation of z of B to its desired
//                  direction, then the rotation about it. With n = sqrt(w^2 + z^2):
//                  2 ((w x - y z) / n, (w y + x z) / n, sgn(w) z / n)
// Limits: at half a turn, `se3` is zero; a body on its back leaves this point only by a
// disturbance. There `tilt_priority` has no tilt axis of its own and uses v's.
//
// Sources: `se3`: T. Lee, M. Leok and N. H. McClamroch, Geometric tracking control of a quadrotor
// UAV on SE(3), CDC 2010, eq. 10. `quaternion`: D. Brescianini, M. Hehn and R. D'Andrea, Nonlinear
// quadrocopter attitude control, ETH Zurich 2013; it is twice e_R of T. Lee, Exponential stability
// of an attitude tracking control system on SO(3) for large-angle rotational maneuvers, Systems &
// Control Letters 61, 2012. `tilt_priority`: D. Brescianini and R. D'Andrea, Tilt-prioritized
// quadrocopter attitude control, IEEE TCST 28(2), 2020, section III.
#pragma once

#include <skybody/plugin.h>

namespace skybody::control {

enum class AttitudeError { kQuaternion, kSe3, kTiltPriority };

/// @param left  q_e, a unit quaternion
template <class Real>
SKYBODY_INLINE Vec3<Real> tilt_priority_error(const Quat<Real>& left) {
  const Real square = left.w * left.w + left.z * left.z;
  const auto has_axis = square > 1e-12;
  const Real scale = 2.0 / sqrt(select(has_axis, square, Real(1.0)));
  const Vec3<Real> error{(left.w * left.x - left.y * left.z) * scale,
                         (left.w * left.y + left.x * left.z) * scale,
                         copysign(scale, left.w) * left.z};
  return select(has_axis, error, Vec3<Real>{2.0 * left.x, 2.0 * left.y, Real(0.0)});
}

/// @param left  q_e, a unit quaternion
template <class Real>
SKYBODY_INLINE Vec3<Real> attitude_error(AttitudeError form, const Quat<Real>& left) {
  if (form == AttitudeError::kTiltPriority) return tilt_priority_error(left);
  const Real twice = form == AttitudeError::kSe3 ? 2.0 * left.w : copysign(Real(2.0), left.w);
  return {twice * left.x, twice * left.y, twice * left.z};
}

/// The form that the parameter `error` names. Declared as a member of the controller `owner`.
class AttitudeErrorChoice {
 public:
  explicit AttitudeErrorChoice(Plugin* owner, const char* standard = "quaternion")
      : word_(owner, choice("error", standard, {"quaternion", "tilt_priority", "se3"},
                            "form of the attitude error")) {}

  void configure() {
    form_ = word_.value() == "se3"             ? AttitudeError::kSe3
            : word_.value() == "tilt_priority" ? AttitudeError::kTiltPriority
                                               : AttitudeError::kQuaternion;
  }
  AttitudeError form() const { return form_; }

  /// @param left  q_e, a unit quaternion
  template <class Real>
  SKYBODY_INLINE Vec3<Real> operator()(const Quat<Real>& left) const {
    return attitude_error(form_, left);
  }

 private:
  TextParameter word_;
  AttitudeError form_ = AttitudeError::kQuaternion;
};

}  // namespace skybody::control
