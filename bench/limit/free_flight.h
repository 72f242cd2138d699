// One physics step of the QDrone2 in the air, written out by hand: rotor lag, all of its rotors'
// effects, one rigid body, semi-implicit Euler. The sums over rotors are closed forms of this
// vehicle's places and senses of rotation (front left +, front right -, back left -, back right +);
// what is constant is folded into constants. No ground.
#pragma once

#include "bench/limit/lane_choice.h"
#include "bench/limit/vehicle.h"
#include "core/base/quat.h"

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

/// Where the values of a Flyer lie in memory, in the order of its members.
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

/// Force over mass and moment on the base, both in body axes.
template <class Real>
struct RotorWrench {
  Vec3<Real> push;    ///< force / kMass [m/s^2]
  Vec3<Real> moment;  ///< about the base's origin [N m]
};

/// Moves the rotors through the step and sums what they do.
/// @param x, y  velocity of the base's origin along the body's axes [m/s]
template <class Real>
SKYBODY_INLINE RotorWrench<Real> turn_rotors(Real* rotor, const Real* command, const Real& x,
                                             const Real& y, const Vec3<Real>& spin) {
  Real w[4], gain[4];
  for (int i = 0; i < 4; ++i) {
    const Real gap = command[i] - rotor[i];
    // A rotor speeds up quicker than it slows down: the larger of both ways is the one to take.
    w[i] = rotor[i] + larger(gap * kRiseHalf, gap * kFallHalf);
    gain[i] = larger(gap * kRise, gap * kFall);
    rotor[i] = rotor[i] + gain[i];
  }
  const Real front = w[0] + w[1], back = w[2] + w[3];
  const Real front_turn = w[0] - w[1], back_turn = w[2] - w[3];
  const Real all = front + back;             // sum of w
  const Real ahead = front - back;           // of w sign(x)
  const Real left = front_turn + back_turn;  // of w sign(y), and of s w sign(x)
  const Real turn = front_turn - back_turn;  // of s w; s w sign(y) sums to `ahead`

  const Real f0 = w[0] * w[0], f1 = w[1] * w[1], f2 = w[2] * w[2], f3 = w[3] * w[3];
  const Real front_f = f0 + f1, back_f = f2 + f3;
  const Real front_d = f0 - f1, back_d = f2 - f3;

  const Real hub_x = x + spin.y * kHubHeight, hub_y = y - spin.x * kHubHeight;
  const Real left_z = spin.z * left, ahead_z = spin.z * ahead;
  constexpr double kPush = kDrag / kMass;
  RotorWrench<Real> out;
  out.push.x = kPush * (kHalfWidth * left_z - hub_x * all);
  out.push.y = -kPush * (hub_y * all + kHalfLength * ahead_z);
  out.push.z = (kThrust / kMass) * (front_f + back_f);

  const Real gyro = kRotorInertia * turn;
  const Real roll_x = kRolling * (hub_x * turn - kHalfWidth * ahead_z);
  const Real roll_y = kRolling * (hub_y * turn + kHalfLength * left_z);
  out.moment.x = (kThrust * kHalfWidth) * (front_d + back_d) - (kHubHeight * kMass) * out.push.y -
                 (roll_x + gyro * spin.y);
  out.moment.y = (kHubHeight * kMass) * out.push.x - (kThrust * kHalfLength) * (front_f - back_f) -
                 (roll_y - gyro * spin.x);
  constexpr double kArm2 = kHalfLength * kHalfLength + kHalfWidth * kHalfWidth;
  out.moment.z = (kDrag * kHalfWidth) * (hub_x * left) - (kDrag * kHalfLength) * (hub_y * ahead) -
                 (kDrag * kArm2) * (spin.z * all) - kMoment * (front_d - back_d) -
                 (kRotorInertia / kDt) * ((gain[0] - gain[1]) - (gain[2] - gain[3]));
  return out;
}

/// q turned by `spin` for a step, to first order, and back to norm 1. The norm before is
/// 1 + d with d = |dt spin / 2|^2: four terms of (1 + d)^(-1/2) are exact to rounding while the
/// vehicle turns below 30 rad/s (d^4 < 2e-15), and a step later so is what they leave.
template <class Real>
SKYBODY_INLINE Quat<Real> turned(const Quat<Real>& q, const Vec3<Real>& spin) {
  const Vec3<Real> h = spin * Real(0.5 * kDt);
  const Quat<Real> p{
      q.w - ((q.x * h.x + q.y * h.y) + q.z * h.z), q.x + ((q.w * h.x + q.y * h.z) - q.z * h.y),
      q.y + ((q.w * h.y + q.z * h.x) - q.x * h.z), q.z + ((q.w * h.z + q.x * h.y) - q.y * h.x)};
  const Real d = ((p.w * p.w + p.x * p.x) + (p.y * p.y + p.z * p.z)) - 1.0;
  const Real scale = 1.0 - d * (0.5 - d * (0.375 - d * 0.3125));
  return {p.w * scale, p.x * scale, p.y * scale, p.z * scale};
}

/// One physics step.
/// @param command  of the rotors, within what they can do [rad/s]
template <class Real>
SKYBODY_INLINE void fly(Flyer<Real>& s, const Real* command) {
  const Mat3<Real> r = to_mat3(s.rotation);
  const Vec3<Real>&v = s.velocity, w = s.spin;
  const Real x = (r.m[0] * v.x + r.m[3] * v.y) + r.m[6] * v.z;
  const Real y = (r.m[1] * v.x + r.m[4] * v.y) + r.m[7] * v.z;
  const RotorWrench<Real> rotors = turn_rotors(s.rotor, command, x, y, w);

  // Euler about the centre of mass, which lies kCom above the origin.
  const Real wx_wz = w.x * w.z, wy_wz = w.y * w.z;
  const Vec3<Real> angular{
      (1.0 / kInertiaX) * (rotors.moment.x + (kCom * kMass) * rotors.push.y) -
          ((kInertiaZ - kInertiaY) / kInertiaX) * wy_wz,
      (1.0 / kInertiaY) * (rotors.moment.y - (kCom * kMass) * rotors.push.x) -
          ((kInertiaX - kInertiaZ) / kInertiaY) * wx_wz,
      (1.0 / kInertiaZ) * rotors.moment.z - ((kInertiaY - kInertiaX) / kInertiaZ) * (w.x * w.y)};
  const Vec3<Real> linear{rotors.push.x - kCom * (angular.y + wx_wz),
                          rotors.push.y + kCom * (angular.x - wy_wz),
                          rotors.push.z + kCom * (w.x * w.x + w.y * w.y)};
  const Vec3<Real> pull = r * linear;
  s.velocity = {v.x + kDt * pull.x, v.y + kDt * pull.y, v.z + (kDt * pull.z - kDt * kGravity)};
  s.spin = {w.x + kDt * angular.x, w.y + kDt * angular.y, w.z + kDt * angular.z};
  s.position += s.velocity * Real(kDt);
  s.rotation = turned(s.rotation, s.spin);
}

}  // namespace skybody::bench::limit
