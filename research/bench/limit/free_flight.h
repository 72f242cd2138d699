// One physics step of the QDrone2 in the air, written by hand: rotor lag, all rotor effects, one
// rigid body, and the default rule of the engine (kMidpointRule, integration_rules.h):
// 1. half a step of the pose,
// 2. a step of the velocities by the explicit midpoint rule at that pose,
// 3. half a step of the pose.
// Rotors enter by the means over the step of their speed and of its square. The sums over rotors
// are closed forms for this vehicle's positions and senses of rotation (front left +, front right
// -, back left -, back right +); constants are folded. No ground.
#pragma once

#include "core/base/math/quat.h"
#include "research/bench/limit/lane_choice.h"
#include "research/bench/limit/vehicle.h"

namespace skybody::bench::limit {

/// State of a quadrotor.
template <class Real>
struct Flyer {
  Vec3<Real> position;  ///< of the base's origin, W [m]
  Quat<Real> rotation;  ///< W from B
  Vec3<Real> velocity;  ///< W [m/s]
  Vec3<Real> spin;      ///< B [rad/s]
  Real rotor[4];        ///< [rad/s]
};

/// Indices of the values of a Flyer in memory, in the order of its members.
enum FlyerValue {
  kPosition = 0,
  kRotation = 3,
  kVelocity = 7,
  kSpin = 10,
  kRotor = 13,
  kFlyerValues = 17
};
template <class Real>
SKYBODY_INLINE Real& flyer_value(Flyer<Real>& s, int k) {
  switch (k) {
    case 0:
      return s.position.x;
    case 1:
      return s.position.y;
    case 2:
      return s.position.z;
    case 3:
      return s.rotation.w;
    case 4:
      return s.rotation.x;
    case 5:
      return s.rotation.y;
    case 6:
      return s.rotation.z;
    case 7:
      return s.velocity.x;
    case 8:
      return s.velocity.y;
    case 9:
      return s.velocity.z;
    case 10:
      return s.spin.x;
    case 11:
      return s.spin.y;
    case 12:
      return s.spin.z;
    default:
      return s.rotor[k - kRotor];
  }
}

/// Sums over the rotors of the means of w and of w^2, with the signs of the hubs' positions.
template <class Real>
struct RotorSums {
  Real all;    ///< of w [rad/s]
  Real ahead;  ///< of w sign(x), and of s w sign(y), with the sense of rotation s
  Real left;   ///< of w sign(y), and of s w sign(x)
  Real turn;   ///< of s w
  Real squared, squared_ahead, squared_left, squared_turn;  ///< the same of w^2 [rad^2/s^2]
  Real spin_up;                                             ///< of s times the change of w
};

/// Advances the rotors by the step.
/// @returns their sums over the step
template <class Real>
SKYBODY_INLINE RotorSums<Real> run_rotors(Real* rotor, const Real* command) {
  Real w[4], f[4], gain[4];
  for (int i = 0; i < 4; ++i) {
    const Real start = rotor[i], gap = command[i] - start;
    // A rotor speeds up faster than it slows down: its gain is the larger of both, and its
    // remaining gap the smaller of both.
    gain[i] = larger(gap * kRise, gap * kFall);
    const Real end = start + gain[i];
    const Real lack = smaller(gap * kRiseLack, gap * kFallLack);
    w[i] = command[i] - (lack + lack);
    f[i] = command[i] * command[i] - lack * ((command[i] + command[i]) + (start + end));
    rotor[i] = end;
  }
  const Real front = w[0] + w[1], back = w[2] + w[3];
  const Real front_turn = w[0] - w[1], back_turn = w[2] - w[3];
  const Real front_f = f[0] + f[1], back_f = f[2] + f[3];
  const Real front_d = f[0] - f[1], back_d = f[2] - f[3];
  return {front + back,           front - back,     front_turn + back_turn,
          front_turn - back_turn, front_f + back_f, front_f - back_f,
          front_d + back_d,       front_d - back_d, (gain[0] - gain[1]) - (gain[2] - gain[3])};
}

/// Force over mass and moment on the base, both in body axes.
template <class Real>
struct RotorWrench {
  Vec3<Real> push;    ///< force / kMass [m/s^2]
  Vec3<Real> moment;  ///< about the base's origin [N m]
};

/// @param x, y  velocity of the base's origin along the body's axes [m/s]
template <class Real>
SKYBODY_INLINE RotorWrench<Real> rotor_wrench(const RotorSums<Real>& rotors, const Real& x,
                                              const Real& y, const Vec3<Real>& spin) {
  const Real hub_x = x + spin.y * kHubHeight, hub_y = y - spin.x * kHubHeight;
  const Real left_z = spin.z * rotors.left, ahead_z = spin.z * rotors.ahead;
  constexpr double kPush = kDrag / kMass;
  RotorWrench<Real> out;
  out.push.x = kPush * (kHalfWidth * left_z - hub_x * rotors.all);
  out.push.y = -kPush * (hub_y * rotors.all + kHalfLength * ahead_z);
  out.push.z = (kThrust / kMass) * rotors.squared;

  const Real gyro = kRotorInertia * rotors.turn;
  const Real roll_x = kRolling * (hub_x * rotors.turn - kHalfWidth * ahead_z);
  const Real roll_y = kRolling * (hub_y * rotors.turn + kHalfLength * left_z);
  out.moment.x = (kThrust * kHalfWidth) * rotors.squared_left - (kHubHeight * kMass) * out.push.y -
                 (roll_x + gyro * spin.y);
  out.moment.y = (kHubHeight * kMass) * out.push.x -
                 (kThrust * kHalfLength) * rotors.squared_ahead - (roll_y - gyro * spin.x);
  constexpr double kArm2 = kHalfLength * kHalfLength + kHalfWidth * kHalfWidth;
  out.moment.z = (kDrag * kHalfWidth) * (hub_x * rotors.left) -
                 (kDrag * kHalfLength) * (hub_y * rotors.ahead) -
                 (kDrag * kArm2) * (spin.z * rotors.all) - kMoment * rotors.squared_turn -
                 (kRotorInertia / kDt) * rotors.spin_up;
  return out;
}

/// q times the quaternion (c, v).
template <class Real>
SKYBODY_INLINE Quat<Real> product(const Quat<Real>& q, const Real& c, const Vec3<Real>& v) {
  return {c * q.w - ((q.x * v.x + q.y * v.y) + q.z * v.z),
          c * q.x + ((q.w * v.x + q.y * v.z) - q.z * v.y),
          c * q.y + ((q.w * v.y + q.z * v.x) - q.x * v.z),
          c * q.z + ((q.w * v.z + q.x * v.y) - q.y * v.x)};
}

/// q rotated by `spin` for half a step. h is half the angle, below 0.0075 for rates below 30 rad/s,
/// so three terms of sine and cosine are exact to rounding (h^6 / 720 < 3e-16).
template <class Real>
SKYBODY_INLINE Quat<Real> turned(const Quat<Real>& q, const Vec3<Real>& spin) {
  const Vec3<Real> h = spin * Real(0.25 * kDt);
  const Real square = dot(h, h);
  return product(q, Real(1.0 - square * (0.5 - square * (1.0 / 24))),
                 Vec3<Real>(h * (1.0 - square * (1.0 / 6 - square * (1.0 / 120)))));
}

/// The same, by the tangent of h and normalized: a step ends with norm 1 whatever the rounding
/// error. The norm before is 1 + d with d = tan(h)^2: four terms of (1 + d)^(-1/2) are exact to
/// rounding (d^4 < 2e-17), and three of the tangent to 1e-14 of h.
template <class Real>
SKYBODY_INLINE Quat<Real> turned_to_unit(const Quat<Real>& q, const Vec3<Real>& spin) {
  const Vec3<Real> h = spin * Real(0.25 * kDt);
  const Real square = dot(h, h);
  const Quat<Real> p =
      product(q, Real(1.0), Vec3<Real>(h * (1.0 + square * (1.0 / 3 + square * (2.0 / 15)))));
  const Real d = ((p.w * p.w + p.x * p.x) + (p.y * p.y + p.z * p.z)) - 1.0;
  const Real scale = 1.0 - d * (0.5 - d * (0.375 - d * 0.3125));
  return {p.w * scale, p.x * scale, p.y * scale, p.z * scale};
}

/// The first half step of the pose.
template <class Real>
SKYBODY_INLINE void drift(Flyer<Real>& s) {
  s.position += s.velocity * Real(0.5 * kDt);
  s.rotation = turned(s.rotation, s.spin);
}
/// The second half step of the pose.
template <class Real>
SKYBODY_INLINE void drift_to_end(Flyer<Real>& s) {
  s.position += s.velocity * Real(0.5 * kDt);
  s.rotation = turned_to_unit(s.rotation, s.spin);
}

/// Accelerations of the base from free fall, body axes.
template <class Real>
struct FlyerRates {
  Vec3<Real> linear;   ///< of the origin [m/s^2]
  Vec3<Real> angular;  ///< [rad/s^2]
};

/// Velocities that the forces on the base depend on.
template <class Real>
struct FlyerVelocity {
  Real x, y;        ///< of the origin along body axes [m/s]
  Vec3<Real> spin;  ///< body axes [rad/s]

  /// @param r  the base's axes in W
  SKYBODY_INLINE FlyerVelocity(const Flyer<Real>& s, const Mat3<Real>& r) : spin(s.spin) {
    const Vec3<Real>& v = s.velocity;
    x = (r.m[0] * v.x + r.m[3] * v.y) + r.m[6] * v.z;
    y = (r.m[1] * v.x + r.m[4] * v.y) + r.m[7] * v.z;
  }
  /// Advances by half a step.
  SKYBODY_INLINE void kick_half(const FlyerRates<Real>& rates, const Mat3<Real>& r) {
    x += (0.5 * kDt) * (rates.linear.x - kGravity * r.m[6]);
    y += (0.5 * kDt) * (rates.linear.y - kGravity * r.m[7]);
    spin += rates.angular * Real(0.5 * kDt);
  }
};

/// The step of the base's velocities.
template <class Real>
SKYBODY_INLINE void kick(Flyer<Real>& s, const FlyerRates<Real>& rates, const Mat3<Real>& r) {
  const Vec3<Real> a = r * rates.linear;
  s.velocity += Vec3<Real>{kDt * a.x, kDt * a.y, kDt * a.z - kDt * kGravity};
  s.spin += rates.angular * Real(kDt);
}

/// Euler's equations about the centre of mass, which is kCom above the origin.
template <class Real>
SKYBODY_INLINE FlyerRates<Real> flyer_rates(const RotorSums<Real>& sums,
                                            const FlyerVelocity<Real>& at) {
  const Vec3<Real>& w = at.spin;
  const RotorWrench<Real> rotors = rotor_wrench(sums, at.x, at.y, w);
  const Real wx_wz = w.x * w.z, wy_wz = w.y * w.z;
  const Vec3<Real> angular{
      (1.0 / kInertiaX) * (rotors.moment.x + (kCom * kMass) * rotors.push.y) -
          ((kInertiaZ - kInertiaY) / kInertiaX) * wy_wz,
      (1.0 / kInertiaY) * (rotors.moment.y - (kCom * kMass) * rotors.push.x) -
          ((kInertiaX - kInertiaZ) / kInertiaY) * wx_wz,
      (1.0 / kInertiaZ) * rotors.moment.z - ((kInertiaY - kInertiaX) / kInertiaZ) * (w.x * w.y)};
  return {{rotors.push.x - kCom * (angular.y + wx_wz), rotors.push.y + kCom * (angular.x - wy_wz),
           rotors.push.z + kCom * (w.x * w.x + w.y * w.y)},
          angular};
}

/// One physics step.
/// @param command  of the rotors, within their limits [rad/s]
template <class Real>
SKYBODY_INLINE void fly(Flyer<Real>& s, const Real* command) {
  const RotorSums<Real> rotors = run_rotors(s.rotor, command);
  drift(s);
  const Mat3<Real> r = to_mat3(s.rotation);
  FlyerVelocity<Real> middle(s, r);
  middle.kick_half(flyer_rates(rotors, middle), r);
  kick(s, flyer_rates(rotors, middle), r);
  drift_to_end(s);
}

}  // namespace skybody::bench::limit
