// One physics step of the QDrone2 with the bob of scenarios/models/qdrone2_payload, written by
// hand: base, rod and bob, ball joints between them. No ground.
//
// A ball joint transmits a force and no moment. All joints and centres of mass are on the z axes of
// their bodies, so a force f at a joint accelerates another joint of the same body by a constant
// diagonal matrix in the body's axes. With f the base's force on the rod and g the rod's force on
// the bob, equal accelerations of both bodies at each joint give
//   base and rod   k0 - G f = k1 + T f + U g
//   rod and bob    k2 - U f - T g = k3 + C g
// two symmetric 3x3 systems, without elimination of coordinates. Both evaluations of a step are at
// one pose, so that the systems are inverted once. Accelerations are relative to free fall.
#pragma once

#include "research/bench/limit/free_flight.h"

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

/// A body at a ball joint.
template <class Real>
struct Turning {
  Quat<Real> rotation;  ///< the parent from the body
  Vec3<Real> spin;      ///< relative to the parent, body axes [rad/s]
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

/// Diagonal matrix from a force at z = `from` to the acceleration at z = `to`.
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

/// State of the quadrotor and its hanging bodies.
template <class Real>
struct Carrier {
  Flyer<Real> base;
  Turning<Real> rod, bob;
};

/// Accelerations.
template <class Real>
struct CarrierRates {
  FlyerRates<Real> base;
  Vec3<Real> rod, bob;  ///< of their spins [rad/s^2]
};

/// The equations at one pose of the joints.
template <class Real>
class Hanging {
 public:
  /// @param rod, bob  as in Carrier
  SKYBODY_INLINE Hanging(const Quat<Real>& rod, const Quat<Real>& bob)
      : base_of_rod_(to_mat3(rod)), rod_of_bob_(to_mat3(bob)) {
    constexpr Compliance<kBase> kG(-kHookArm, -kHookArm);
    constexpr Compliance<kRod> kT(kRodArm, kRodArm);
    constexpr Compliance<kBob> kC(kBobArm, kBobArm);
    const Real none(0.0);
    SymMat3<Real> lower{Real(kT.x), Real(kT.y), Real(kT.z), none, none, none};
    add_turned(lower, transpose(rod_of_bob_), kC.x, kC.y, kC.z);
    const SymMat3<Real> h = inverse(lower);  // of C + T
    SymMat3<Real> upper{
        kT.x - (kAcross.x * kAcross.x) * h.xx, kT.y - (kAcross.y * kAcross.y) * h.yy,
        kT.z - (kAcross.z * kAcross.z) * h.zz, -(kAcross.x * kAcross.y) * h.xy,
        -(kAcross.x * kAcross.z) * h.xz,       -(kAcross.y * kAcross.z) * h.yz};
    add_turned(upper, base_of_rod_, kG.x, kG.y, kG.z);
    lower_ = h;
    upper_ = inverse(upper);
  }

  /// @param rod_spin, bob_spin  as in Carrier
  SKYBODY_INLINE CarrierRates<Real> rates(const RotorSums<Real>& sums,
                                          const FlyerVelocity<Real>& at, const Vec3<Real>& rod_spin,
                                          const Vec3<Real>& bob_spin) const {
    const Vec3<Real>& w = at.spin;
    const Vec3<Real> carried = transpose_times(base_of_rod_, w), w1 = carried + rod_spin;
    const Vec3<Real> hanging = transpose_times(rod_of_bob_, w1), w2 = hanging + bob_spin;
    const RotorWrench<Real> rotors = rotor_wrench(sums, at.x, at.y, w);

    // Each body without its hanging bodies.
    Vec3<Real> base_turn = gyration<kBase>(w);
    base_turn.x += (1.0 / kBase.x) * (rotors.moment.x + (kCom * kMass) * rotors.push.y);
    base_turn.y += (1.0 / kBase.y) * (rotors.moment.y - (kCom * kMass) * rotors.push.x);
    base_turn.z += (1.0 / kBase.z) * rotors.moment.z;
    const Vec3<Real> k0 = rotors.push + on_axis(base_turn, w, -kHookArm);
    const Vec3<Real> rod_turn = gyration<kRod>(w1), k1 = on_axis(rod_turn, w1, kRodArm);
    const Vec3<Real> bob_turn = gyration<kBob>(w2), k3 = on_axis(bob_turn, w2, kBobArm);

    // In rod axes. U f = -kAcross f in any axes: the force on the lower end of the rod is -g.
    const Vec3<Real> seen = lower_ * (-k1 - rod_of_bob_ * k3);  // g if f were 0; k2 is -k1
    const Vec3<Real> f = upper_ * (transpose_times(base_of_rod_, k0) - k1 + across(seen));
    const Vec3<Real> g = seen + lower_ * across(f);

    // Transforms back to the bodies' axes.
    const Vec3<Real> pull = base_of_rod_ * f, hang = transpose_times(rod_of_bob_, g);
    const Vec3<Real> angular{base_turn.x - (kHookArm / kBase.x) * pull.y,
                             base_turn.y + (kHookArm / kBase.y) * pull.x, base_turn.z};
    const Vec3<Real> push = rotors.push - pull * Real(1.0 / kMass);
    const Vec3<Real> rod = pulled<kRod>(rod_turn, kRodArm, Vec3<Real>(f + g));
    const Vec3<Real> bob = pulled<kBob>(bob_turn, kBobArm, hang);
    // Relative to the parent, whose axes rotate in those of the body.
    return {{push - on_axis(angular, w, kCom), angular},
            rod - transpose_times(base_of_rod_, angular) + cross(rod_spin, carried),
            bob - transpose_times(rod_of_bob_, rod) + cross(bob_spin, hanging)};
  }

 private:
  static constexpr Compliance<kRod> kAcross{kRodArm, -kRodArm};

  static SKYBODY_INLINE Vec3<Real> across(const Vec3<Real>& f) {
    return {kAcross.x * f.x, kAcross.y * f.y, kAcross.z * f.z};
  }
  /// Angular acceleration due to a force at z = `arm`.
  template <LinkConstants kLink>
  static SKYBODY_INLINE Vec3<Real> pulled(const Vec3<Real>& free, double arm,
                                          const Vec3<Real>& force) {
    return {free.x - (arm / kLink.x) * force.y, free.y + (arm / kLink.y) * force.x, free.z};
  }

  Mat3<Real> base_of_rod_, rod_of_bob_;
  SymMat3<Real> lower_, upper_;  ///< inverses of the two systems
};

/// One physics step.
/// @param command  of the rotors, within their limits [rad/s]
template <class Real>
SKYBODY_INLINE void fly(Carrier<Real>& s, const Real* command) {
  const RotorSums<Real> rotors = run_rotors(s.base.rotor, command);
  drift(s.base);
  s.rod.rotation = turned(s.rod.rotation, s.rod.spin);
  s.bob.rotation = turned(s.bob.rotation, s.bob.spin);
  const Mat3<Real> r = to_mat3(s.base.rotation);
  const Hanging<Real> pose(s.rod.rotation, s.bob.rotation);
  FlyerVelocity<Real> middle(s.base, r);
  const CarrierRates<Real> first = pose.rates(rotors, middle, s.rod.spin, s.bob.spin);
  middle.kick_half(first.base, r);
  const Real half(0.5 * kDt);
  const CarrierRates<Real> second =
      pose.rates(rotors, middle, Vec3<Real>(s.rod.spin + first.rod * half),
                 Vec3<Real>(s.bob.spin + first.bob * half));
  kick(s.base, second.base, r);
  s.rod.spin += second.rod * Real(kDt);
  s.bob.spin += second.bob * Real(kDt);
  drift_to_end(s.base);
  s.rod.rotation = turned_to_unit(s.rod.rotation, s.rod.spin);
  s.bob.rotation = turned_to_unit(s.bob.rotation, s.bob.spin);
}

}  // namespace skybody::bench::limit
