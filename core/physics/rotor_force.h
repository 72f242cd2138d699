// What a spinning rotor does to its body. F. Furrer, M. Burri, M. Achtelik, R. Siegwart, "RotorS -
// A modular Gazebo MAV simulator framework", 2016, section "Rotor dynamics", after P. Martin and E.
// Salaun, "The true role of accelerometer feedback in quadrotor control", ICRA 2010. Collective
// thrust and torque of paper eq. 1 are the sums over a robot's rotors.
//
// With w >= 0 the speed, n the axis, s = +1 for counter-clockwise about n, and v' the hub's
// velocity across the axis (still air):
//   thrust            F = k_f w^2 n
//   reaction          M = -s k_m w^2 n
//   rotor drag        F = -c_d w v'
//   rolling moment    M = -s c_r w v'    (RotorS' code leaves out s; which side the advancing
//                                         blade is on, so the sign, goes with the direction)
//   gyroscopic        M = -omega x (s J w n)
//   spin-up           M = -s J (dw/dt) n
// The last two vanish for rotor inertia J = 0.
#pragma once

#include "core/base/vec3.h"
#include "core/model/layout.h"
#include "core/physics/rotor_lag.h"
#include "core/physics/spatial_force.h"

namespace skybody {

/// A rotor on its body.
struct RotorPlace {
  Vec3<double> position, axis;  ///< hub [m] and thrust direction, body axes
  double direction = 1.0;       ///< +1 or -1
  double squared_radius = 0.0;  ///< of the hub from the body's z axis [m^2]
  int params = 0;               ///< first of its kRotorParamCount values
};

/// Adds one rotor's forces to `sum`, which is about the body's origin like any SpatialForce but in
/// the axes of the body.
/// @param constants  the rotor's kRotorParamCount values
/// @param velocity, spin  of the body's origin [m/s] and body [rad/s], body axes
template <class Real, class Constants>
SKYBODY_INLINE void add_rotor_force(const Constants& constants, const RotorPlace& place,
                                    const RotorMotion<Real>& rotor, const Vec3<Real>& velocity,
                                    const Vec3<Real>& spin, SpatialForce<Real>& sum) {
  const Vec3<Real> position = to_real<Real>(place.position), axis = to_real<Real>(place.axis);
  const Real w = rotor.speed, signed_w = place.direction * w;
  const Vec3<Real> hub = velocity + cross(spin, position);
  const Vec3<Real> across = hub - axis * dot(hub, axis);
  const Vec3<Real> force =
      axis * (constants[kThrustConstant] * (w * w)) - across * (constants[kDragConstant] * w);
  const Real momentum = constants[kRotorInertia] * signed_w;
  const Real about_axis = constants[kMomentConstant] * (signed_w * w) +
                          constants[kRotorInertia] * (place.direction * rotor.acceleration);
  sum.add_force_at(position, force);
  sum.moment -= across * (constants[kRollingMomentConstant] * signed_w) +
                cross(spin, axis * momentum) + axis * about_axis;
}

/// Rotors of one body with the body's z as their axis and their hubs at one height: what they do
/// together, from sums over the rotors that know nothing of the body's motion.
template <class Real>
class LevelRotors {
 public:
  LevelRotors() = default;
  /// No rotor yet.
  static SKYBODY_INLINE LevelRotors none() {
    const Real zero(0.0);
    return {zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero};
  }

  /// @param constants  the rotor's kRotorParamCount values
  template <class Constants>
  SKYBODY_INLINE void add(const Constants& constants, const RotorPlace& place,
                          const RotorMotion<Real>& rotor) {
    const double x = place.position.x, y = place.position.y;
    const Real w = rotor.speed, signed_w = place.direction * w;
    const Real thrust = constants[kThrustConstant] * (w * w);
    const Real drag = constants[kDragConstant] * w;
    const Real rolling = constants[kRollingMomentConstant] * signed_w;
    thrust_ += thrust;
    thrust_x_ += x * thrust;
    thrust_y_ += y * thrust;
    drag_ += drag;
    drag_x_ += x * drag;
    drag_y_ += y * drag;
    drag_xy_ += place.squared_radius * drag;
    rolling_ += rolling;
    rolling_x_ += x * rolling;
    rolling_y_ += y * rolling;
    momentum_ += constants[kRotorInertia] * signed_w;
    about_axis_ += constants[kMomentConstant] * (signed_w * w) +
                   constants[kRotorInertia] * (place.direction * rotor.acceleration);
  }

  /// @param height  of the hubs above the body's origin [m]
  /// @param velocity, spin  as for add_rotor_force
  /// @returns about the body's origin, body axes
  SKYBODY_INLINE SpatialForce<Real> force(double height, const Vec3<Real>& velocity,
                                          const Vec3<Real>& spin) const {
    // Velocity across the axis of a hub at x, y: (hub_x - spin_z y, hub_y + spin_z x).
    const Real hub_x = velocity.x + spin.y * height, hub_y = velocity.y - spin.x * height;
    const Vec3<Real> f{spin.z * drag_y_ - hub_x * drag_, -(hub_y * drag_ + spin.z * drag_x_),
                       thrust_};
    const Real roll_x = hub_x * rolling_ - spin.z * rolling_y_;
    const Real roll_y = hub_y * rolling_ + spin.z * rolling_x_;
    return {{(thrust_y_ - height * f.y) - (roll_x + spin.y * momentum_),
             (height * f.x - thrust_x_) - (roll_y - spin.x * momentum_),
             ((hub_x * drag_y_ - hub_y * drag_x_) - spin.z * drag_xy_) - about_axis_},
            f};
  }

 private:
  SKYBODY_INLINE LevelRotors(const Real& t, const Real& tx, const Real& ty, const Real& d,
                             const Real& dx, const Real& dy, const Real& dxy, const Real& r,
                             const Real& rx, const Real& ry, const Real& m, const Real& a)
      : thrust_(t),
        thrust_x_(tx),
        thrust_y_(ty),
        drag_(d),
        drag_x_(dx),
        drag_y_(dy),
        drag_xy_(dxy),
        rolling_(r),
        rolling_x_(rx),
        rolling_y_(ry),
        momentum_(m),
        about_axis_(a) {}

  Real thrust_, thrust_x_, thrust_y_;      ///< [N], times place [N m]
  Real drag_, drag_x_, drag_y_, drag_xy_;  ///< c_d w [N s/m], times place, times its square
  Real rolling_, rolling_x_, rolling_y_;   ///< s c_r w [N s], times place
  Real momentum_;                          ///< s J w [kg m^2/s]
  Real about_axis_;                        ///< s (k_m w^2 + J dw/dt) [N m]
};

/// Consecutive rotors on one body.
struct RotorGroup {
  int body = 0, first = 0, count = 0;
  bool is_level = false;  ///< they go as LevelRotors
};

/// The sums of a level group.
/// @param places, params, motion  as for sum_rotors
template <class Real, class Params, class Motion>
SKYBODY_INLINE LevelRotors<Real> sum_level_rotors(const RotorGroup& group, const RotorPlace* places,
                                                  const Params& params, Motion&& motion) {
  LevelRotors<Real> rotors = LevelRotors<Real>::none();
  for (int i = group.first; i < group.first + group.count; ++i) {
    rotors.add(params + places[i].params, places[i], motion(i));
  }
  return rotors;
}

/// What the rotors of any group do to their body, one by one.
/// @param places    of all rotors of the world
/// @param params    of the environment
/// @param motion    motion(i) says how rotor i of the world moves
/// @param velocity, spin  of the body's origin [m/s] and body [rad/s], body axes
/// @returns about the body's origin, body axes
template <class Real, class Params, class Motion>
SKYBODY_INLINE SpatialForce<Real> sum_rotors(const RotorGroup& group, const RotorPlace* places,
                                             const Params& params, Motion&& motion,
                                             const Vec3<Real>& velocity, const Vec3<Real>& spin) {
  SpatialForce<Real> sum = SpatialForce<Real>::zero();
  for (int i = group.first; i < group.first + group.count; ++i) {
    add_rotor_force(params + places[i].params, places[i], motion(i), velocity, spin, sum);
  }
  return sum;
}

/// The same by the quicker way where there is one.
template <class Real, class Params, class Motion>
SKYBODY_INLINE SpatialForce<Real> rotor_forces(const RotorGroup& group, const RotorPlace* places,
                                               const Params& params, Motion&& motion,
                                               const Vec3<Real>& velocity, const Vec3<Real>& spin) {
  if (!group.is_level) return sum_rotors<Real>(group, places, params, motion, velocity, spin);
  return sum_level_rotors<Real>(group, places, params, motion)
      .force(places[group.first].position.z, velocity, spin);
}

}  // namespace skybody
