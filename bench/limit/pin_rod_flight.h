// One physics step of the QDrone2 with a rod on a pin (bench/scenarios/models/qdrone2_pin_rod),
// written out by hand. No ground.
//
// The centre of mass of both bodies moves by the outer forces alone; about it, four coordinates are
// left: the base's rotation and the pin's angle. With d from the base's centre of mass to the rod's
// and m = m0 m1 / (m0 + m1), in base axes,
//   (I0 + I1 + m (d^2 - d d^T)) a + (I1 y + m d x e) p = moments
//   (I1 y + m d x e) a + (y I1 y + m e e) p            = moment about the pin
// where y is the pin's axis, p its acceleration and e = y x r1 what d gains per unit of angle.
#pragma once

#include "bench/limit/free_flight.h"

namespace skybody::bench::limit {

/// A slender rod with a weight at its end; it hangs 0.03 m below the base's origin from a pin along
/// the base's y axis, its centre of mass `arm` further down at angle 0.
struct PinRod {
  double mass = 0.2;                        ///< [kg]
  double arm = 0.4;                         ///< [m]
  double x = 0.004, y = 0.004, z = 0.0001;  ///< about its centre of mass, its axes [kg m^2]
  double damping = 0.001;                   ///< of the pin [N m s/rad]
};
constexpr PinRod kPinRod{};
constexpr double kPinArm = 0.03 + kCom;  ///< pin below the base's centre of mass [m]

/// State of the quadrotor and the rod.
template <class Real>
struct Swinger {
  Flyer<Real> base;
  Real angle, rate;  ///< of the pin [rad, rad/s]
};

/// One physics step.
/// @param command  of the rotors, within what they can do [rad/s]
template <class Real>
SKYBODY_INLINE void fly(Swinger<Real>& s, const Real* command) {
  const Mat3<Real> r = to_mat3(s.base.rotation);
  const Vec3<Real>&v = s.base.velocity, w = s.base.spin;
  const Real vx = (r.m[0] * v.x + r.m[3] * v.y) + r.m[6] * v.z;
  const Real vy = (r.m[1] * v.x + r.m[4] * v.y) + r.m[7] * v.z;
  const RotorWrench<Real> rotors = turn_rotors(s.base.rotor, command, vx, vy, w);

  // The rod's inertia in base axes: turned about y by the angle.
  const SinCos<Real> turn = sincos_of(s.angle);
  const Real ss = turn.sin * turn.sin;
  constexpr double kFlat = kPinRod.z - kPinRod.x;
  const Real ixx = kPinRod.x + kFlat * ss, izz = kPinRod.z - kFlat * ss;
  const Real ixz = kFlat * (turn.sin * turn.cos);
  const auto rod_inertia = [&](const Vec3<Real>& u) __attribute__((always_inline)) {
    return Vec3<Real>{ixx * u.x + ixz * u.z, kPinRod.y * u.y, ixz * u.x + izz * u.z};
  };

  // d, e and the rod's rates. r1 from the pin to its centre of mass, r0 to the base's.
  const Real r1x = -kPinRod.arm * turn.sin, r1z = -kPinRod.arm * turn.cos;
  const Real dx = r1x, dz = r1z - kPinArm;  // d.y = 0
  const Real ex = r1z, ez = -r1x;           // e.y = 0
  const Vec3<Real> w1{w.x, w.y + s.rate, w.z};
  const auto swirl = [](const Vec3<Real>& u, const Real& x, const Real& z)
      __attribute__((always_inline)) {  // u x (u x (x, 0, z))
    const Real along = u.x * x + u.z * z, square = (u.x * u.x + u.y * u.y) + u.z * u.z;
    return Vec3<Real>{u.x * along - x * square, u.y * along, u.z * along - z * square};
  };
  // w x y rate: what turns the pin's axis.
  const Real cx = -(w.z * s.rate), cz = w.x * s.rate;
  const Vec3<Real> rod = swirl(w1, r1x, r1z), base = swirl(w, Real(0.0), Real(kPinArm));
  Vec3<Real> bias = rod - base;  // d's second derivative without accelerations; and (c x r1):
  bias.y += cz * r1x - cx * r1z;

  constexpr double kAll = kMass + kPinRod.mass, kReduced = kMass * kPinRod.mass / kAll;
  // The force on d, from the rotors at the base and from bias.
  const Vec3<Real> pull = (rotors.push * Real(kReduced) + bias * Real(kReduced)) * Real(-1.0);
  const Vec3<Real> l1 = rod_inertia(w1), c1 = rod_inertia({cx, Real(0.0), cz});
  const Vec3<Real> gyro1 = cross(w1, l1) + c1;
  const Vec3<Real> l0{kInertiaX * w.x, kInertiaY * w.y, kInertiaZ * w.z};
  const Vec3<Real> gyro0 = cross(w, l0);
  const Vec3<Real> moment{
      ((rotors.moment.x + (kCom * kMass) * rotors.push.y) - (gyro0.x + gyro1.x)) - dz * pull.y,
      ((rotors.moment.y - (kCom * kMass) * rotors.push.x) - (gyro0.y + gyro1.y)) +
          (dz * pull.x - dx * pull.z),
      (rotors.moment.z - (gyro0.z + gyro1.z)) + dx * pull.y};
  const Real pin = (ex * pull.x + ez * pull.z) - gyro1.y - kPinRod.damping * s.rate;

  // The pin's angle out, the rest by cofactors. I1 y + m d x e has a y component only.
  const Real mdx = kReduced * dx, mdz = kReduced * dz;
  const Real coupling = kPinRod.y + (mdz * ex - mdx * ez);
  constexpr double kPinInertia = kPinRod.y + kReduced * kPinRod.arm * kPinRod.arm;
  const Real xx = (kInertiaX + ixx) + mdz * dz, zz = (kInertiaZ + izz) + mdx * dx;
  const Real xz = ixz - mdx * dz;
  const Real yy =
      ((kInertiaY + kPinRod.y) + (mdx * dx + mdz * dz)) - coupling * coupling * (1.0 / kPinInertia);
  const Real flat = 1.0 / ((xx * zz - xz * xz) * yy);
  const Real by_xz = flat * yy;
  const Vec3<Real> angular{
      by_xz * (zz * moment.x - xz * moment.z),
      (flat * (xx * zz - xz * xz)) * (moment.y - coupling * (pin * (1.0 / kPinInertia))),
      by_xz * (xx * moment.z - xz * moment.x)};
  const Real pin_rate = (pin - coupling * angular.y) * (1.0 / kPinInertia);

  // d'' and with it the base's centre of mass, then its origin.
  const Vec3<Real> away{(angular.y * dz + ex * pin_rate) + bias.x,
                        (angular.z * dx - angular.x * dz) + bias.y,
                        (ez * pin_rate - angular.y * dx) + bias.z};
  constexpr double kShare = kPinRod.mass / kAll;
  const Vec3<Real> center = rotors.push * Real(kMass / kAll) - away * Real(kShare);
  const Vec3<Real> linear{center.x - kCom * (angular.y + w.x * w.z),
                          center.y + kCom * (angular.x - w.y * w.z),
                          center.z + kCom * (w.x * w.x + w.y * w.y)};
  const Vec3<Real> a = r * linear;
  s.base.velocity = {v.x + kDt * a.x, v.y + kDt * a.y, v.z + (kDt * a.z - kDt * kGravity)};
  s.base.spin = {w.x + kDt * angular.x, w.y + kDt * angular.y, w.z + kDt * angular.z};
  s.base.position += s.base.velocity * Real(kDt);
  s.base.rotation = turned(s.base.rotation, s.base.spin);
  s.rate += kDt * pin_rate;
  s.angle += kDt * s.rate;
}

}  // namespace skybody::bench::limit
