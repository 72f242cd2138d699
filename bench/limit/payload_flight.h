// One physics step of the QDrone2 with the bob of scenarios/models/qdrone2_payload, written out by
// hand: base, rod and bob, ball joints between them. No ground.
//
// A ball joint passes a force and no moment, and every joint lies on its bodies' z axes, as do the
// centres of mass: what a force f at a joint does to the acceleration of a joint of the same body
// is then a constant diagonal matrix in the body's axes. With f the base's force on the rod and g
// the rod's on the bob, "the joint's point accelerates alike on both its bodies" is
//   base and rod   k0 - G f = k1 + T f + U g
//   rod and bob    k2 - U f - T g = k3 + C g
// two symmetric 3x3 systems, and no elimination of coordinates. Each body's rotation
// and rates are its own (not its parent's), so that a step needs no kinematics down the chain;
// accelerations count from free fall.
#pragma once

#include "bench/limit/free_flight.h"

namespace skybody::bench::limit {

/// A body with its centre of mass on its z axis and principal axes along its own.
struct LinkConstants {
  double mass;     ///< [kg]
  double x, y, z;  ///< moments of inertia about the centre of mass [kg m^2]
};
constexpr LinkConstants kBase{kMass, kInertiaX, kInertiaY, kInertiaZ};
constexpr LinkConstants kRod{0.012, 0.001000075, 0.001000075, 1.5e-7};
constexpr LinkConstants kBob{0.205, 0.00098, 0.00098, 0.00098};
constexpr double kHookArm = 0.03 + kCom;  ///< upper joint below the base's centre of mass [m]
constexpr double kRodArm = 0.5;           ///< joints above and below the rod's [m]
constexpr double kBobArm = 0.07;          ///< lower joint above the bob's [m]

/// A body's rotation and rates.
template <class Real>
struct Turning {
  Quat<Real> rotation;  ///< W from the body
  Vec3<Real> spin;      ///< its axes [rad/s]
};

/// Angular acceleration without moments: -I^-1 (w x I w).
template <LinkConstants kLink, class Real>
SKYBODY_INLINE Vec3<Real> gyration(const Vec3<Real>& w) {
  Vec3<Real> a{Real(0.0), Real(0.0), Real(0.0)};
  if constexpr (kLink.y != kLink.z) a.x = ((kLink.y - kLink.z) / kLink.x) * (w.y * w.z);
  if constexpr (kLink.z != kLink.x) a.y = ((kLink.z - kLink.x) / kLink.y) * (w.z * w.x);
  if constexpr (kLink.x != kLink.y) a.z = ((kLink.x - kLink.y) / kLink.z) * (w.x * w.y);
  return a;
}

/// Acceleration of the point `z` above a centre of mass at rest: a x r + w x (w x r).
template <class Real>
SKYBODY_INLINE Vec3<Real> on_axis(const Vec3<Real>& angular, const Vec3<Real>& w, double z) {
  return {z * (angular.y + w.x * w.z), z * (w.y * w.z - angular.x), -z * (w.x * w.x + w.y * w.y)};
}

/// Diagonal of: force at z = `from` to acceleration at z = `to`.
template <LinkConstants kLink>
struct Compliance {
  double x, y, z;
  constexpr Compliance(double from, double to)
      : x(1.0 / kLink.mass + from * to / kLink.y),
        y(1.0 / kLink.mass + from * to / kLink.x),
        z(1.0 / kLink.mass) {}
};

/// a + other d other^T in other axes, for a diagonal d: rows of `other` are d's axes.
template <class Real>
SKYBODY_INLINE void add_turned(SymMat3<Real>& sum, const Mat3<Real>& rows, double x, double y,
                               double z) {
  const Vec3<Real> a = rows.row(0), b = rows.row(1);
  const Vec3<Real> da = a * Real(x - z), db = b * Real(y - z);
  sum.xx += z + (a.x * da.x + b.x * db.x);
  sum.yy += z + (a.y * da.y + b.y * db.y);
  sum.zz += z + (a.z * da.z + b.z * db.z);
  sum.xy += a.x * da.y + b.x * db.y;
  sum.xz += a.x * da.z + b.x * db.z;
  sum.yz += a.y * da.z + b.y * db.z;
}

/// State of the quadrotor and what hangs on it.
template <class Real>
struct Carrier {
  Flyer<Real> base;
  Turning<Real> rod, bob;
};

/// One physics step.
/// @param command  of the rotors, within what they can do [rad/s]
template <class Real>
SKYBODY_INLINE void fly(Carrier<Real>& s, const Real* command) {
  const Mat3<Real> r = to_mat3(s.base.rotation);
  const Vec3<Real>&v = s.base.velocity, w = s.base.spin;
  const Real x = (r.m[0] * v.x + r.m[3] * v.y) + r.m[6] * v.z;
  const Real y = (r.m[1] * v.x + r.m[4] * v.y) + r.m[7] * v.z;
  const RotorWrench<Real> rotors = turn_rotors(s.base.rotor, command, x, y, w);

  // Each body as if nothing hung on it.
  Vec3<Real> base_turn = gyration<kBase>(w);
  base_turn.x += (1.0 / kBase.x) * (rotors.moment.x + (kCom * kMass) * rotors.push.y);
  base_turn.y += (1.0 / kBase.y) * (rotors.moment.y - (kCom * kMass) * rotors.push.x);
  base_turn.z += (1.0 / kBase.z) * rotors.moment.z;
  const Vec3<Real> k0 = rotors.push + on_axis(base_turn, w, -kHookArm);
  const Vec3<Real> rod_turn = gyration<kRod>(s.rod.spin);
  const Vec3<Real> k1 = on_axis(rod_turn, s.rod.spin, kRodArm);
  const Vec3<Real> bob_turn = gyration<kBob>(s.bob.spin);
  const Vec3<Real> k3 = on_axis(bob_turn, s.bob.spin, kBobArm);

  // In rod axes.
  const Mat3<Real> base_of_rod = to_mat3(conjugate(s.base.rotation) * s.rod.rotation);
  const Mat3<Real> bob_of_rod = to_mat3(conjugate(s.bob.rotation) * s.rod.rotation);
  constexpr Compliance<kBase> kG(-kHookArm, -kHookArm);
  constexpr Compliance<kRod> kT(kRodArm, kRodArm), kAcross(kRodArm, -kRodArm);
  constexpr Compliance<kBob> kC(kBobArm, kBobArm);
  const Real none(0.0);
  SymMat3<Real> lower{Real(kT.x), Real(kT.y), Real(kT.z), none, none, none};
  add_turned(lower, bob_of_rod, kC.x, kC.y, kC.z);
  const SymMat3<Real> h = inverse(lower);  // of C + T
  // U f = -kAcross f, whichever way: the rod feels -g below.
  const Vec3<Real> seen = h * (-k1 - transpose_times(bob_of_rod, k3));  // g if f were 0
  SymMat3<Real> upper{kT.x - (kAcross.x * kAcross.x) * h.xx, kT.y - (kAcross.y * kAcross.y) * h.yy,
                      kT.z - (kAcross.z * kAcross.z) * h.zz, -(kAcross.x * kAcross.y) * h.xy,
                      -(kAcross.x * kAcross.z) * h.xz,       -(kAcross.y * kAcross.z) * h.yz};
  add_turned(upper, base_of_rod, kG.x, kG.y, kG.z);
  const Vec3<Real> across{kAcross.x * seen.x, kAcross.y * seen.y, kAcross.z * seen.z};
  const Vec3<Real> f = inverse(upper) * (transpose_times(base_of_rod, k0) - k1 + across);
  const Vec3<Real> g = seen + h * Vec3<Real>{kAcross.x * f.x, kAcross.y * f.y, kAcross.z * f.z};

  // Back to the bodies.
  const Vec3<Real> pull = base_of_rod * f, hang = bob_of_rod * g;
  const Vec3<Real> angular{base_turn.x - (kHookArm / kBase.x) * pull.y,
                           base_turn.y + (kHookArm / kBase.y) * pull.x, base_turn.z};
  const Vec3<Real> push = rotors.push - pull * Real(1.0 / kMass);
  const Vec3<Real> linear = push - Vec3<Real>(on_axis(angular, w, kCom));
  const Vec3<Real> a = r * linear;
  s.base.velocity = {v.x + kDt * a.x, v.y + kDt * a.y, v.z + (kDt * a.z - kDt * kGravity)};
  s.base.spin = {w.x + kDt * angular.x, w.y + kDt * angular.y, w.z + kDt * angular.z};
  s.base.position += s.base.velocity * Real(kDt);
  s.base.rotation = turned(s.base.rotation, s.base.spin);

  const auto turn = [](Turning<Real>& body, const Vec3<Real>& free, double by_x, double by_y,
                       const Vec3<Real>& force) {
    body.spin.x += kDt * (free.x - by_x * force.y);
    body.spin.y += kDt * (free.y + by_y * force.x);
    body.spin.z += kDt * free.z;
    body.rotation = turned(body.rotation, body.spin);
  };
  turn(s.rod, rod_turn, kRodArm / kRod.x, kRodArm / kRod.y, f + g);
  turn(s.bob, bob_turn, kBobArm / kBob.x, kBobArm / kBob.y, hang);
}

}  // namespace skybody::bench::limit
