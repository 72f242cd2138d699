// One physics step of the QDrone2 with a rod on a pin
// (research/bench/scenarios/models/qdrone2_pin_rod), written by hand. No ground.
//
// Only the outer forces move the centre of mass of both bodies; about it, four coordinates remain:
// the base's rotation and the pin's angle. With d from the base's centre of mass to the rod's
// and m = m0 m1 / (m0 + m1), in base axes,
//   (I0 + I1 + m (d^2 - d d^T)) a + (I1 y + m d x e) p = moments
//   (I1 y + m d x e) a + (y I1 y + m e e) p            = moment about the pin
// where y is the pin's axis, p its acceleration and e = y x r1 the derivative of d by the angle.
#pragma once

#include "research/bench/limit/free_flight.h"

namespace skybody::bench::limit {

/// A slender rod with a weight at its end. It hangs 0.03 m below the base's origin from a pin along
/// the base's y axis; its centre of mass is `arm` further down at angle 0.
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

/// Accelerations.
template <class Real>
struct SwingerRates {
  FlyerRates<Real> base;
  Real rate;  ///< of the pin [rad/s^2]
};

/// The equations at one angle of the pin, shared by both evaluations of a step.
template <class Real>
class PinRodPose {
 public:
  SKYBODY_INLINE explicit PinRodPose(const Real& angle) {
    const SinCos<Real> turn = sincos_of(angle);
    const Real ss = turn.sin * turn.sin;
    constexpr double kFlat = kPinRod.z - kPinRod.x;
    ixx_ = kPinRod.x + kFlat * ss;
    izz_ = kPinRod.z - kFlat * ss;
    ixz_ = kFlat * (turn.sin * turn.cos);
    r1x_ = -kPinRod.arm * turn.sin;
    r1z_ = -kPinRod.arm * turn.cos;
    dz_ = r1z_ - kPinArm;

    // I1 y + m d x e has a y component only.
    const Real mdx = kReduced * r1x_, mdz = kReduced * dz_;
    coupling_ = kPinRod.y + (mdz * r1z_ + mdx * r1x_);
    const Real xx = (kInertiaX + ixx_) + mdz * dz_, zz = (kInertiaZ + izz_) + mdx * r1x_;
    const Real xz = ixz_ - mdx * dz_;
    const Real yy = ((kInertiaY + kPinRod.y) + (mdx * r1x_ + mdz * dz_)) -
                    coupling_ * coupling_ * (1.0 / kPinInertia);
    const Real flat = xx * zz - xz * xz, one_by = 1.0 / (flat * yy), by_xz = one_by * yy;
    xx_ = by_xz * zz;
    xz_ = -(by_xz * xz);
    zz_ = by_xz * xx;
    yy_ = one_by * flat;
  }

  SKYBODY_INLINE SwingerRates<Real> rates(const RotorSums<Real>& sums,
                                          const FlyerVelocity<Real>& at, const Real& rate) const {
    const Vec3<Real>& w = at.spin;
    const RotorWrench<Real> rotors = rotor_wrench(sums, at.x, at.y, w);
    // d, e and the rod's rates: d = (r1.x, 0, dz), e = y x r1 = (r1.z, 0, -r1.x).
    const Real &dx = r1x_, &dz = dz_, &ex = r1z_, ez = -r1x_;
    const Vec3<Real> w1{w.x, w.y + rate, w.z};
    // w x y rate: rate of change of the pin's axis.
    const Real cx = -(w.z * rate), cz = w.x * rate;
    const Vec3<Real> rod = swirl(w1, r1x_, r1z_), base = swirl(w, Real(0.0), Real(kPinArm));
    Vec3<Real> bias = rod - base;  // d's second derivative without accelerations; and (c x r1):
    bias.y += cz * r1x_ - cx * r1z_;

    // The force on d, from the rotors at the base and from the bias.
    const Vec3<Real> pull = (rotors.push * Real(kReduced) + bias * Real(kReduced)) * Real(-1.0);
    const Vec3<Real> gyro1 = cross(w1, rod_inertia(w1)) + rod_inertia({cx, Real(0.0), cz});
    const Vec3<Real> gyro0 =
        cross(w, Vec3<Real>{kInertiaX * w.x, kInertiaY * w.y, kInertiaZ * w.z});
    const Vec3<Real> moment{
        ((rotors.moment.x + (kCom * kMass) * rotors.push.y) - (gyro0.x + gyro1.x)) - dz * pull.y,
        ((rotors.moment.y - (kCom * kMass) * rotors.push.x) - (gyro0.y + gyro1.y)) +
            (dz * pull.x - dx * pull.z),
        (rotors.moment.z - (gyro0.z + gyro1.z)) + dx * pull.y};
    const Real pin = (ex * pull.x + ez * pull.z) - gyro1.y - kPinRod.damping * rate;

    const Vec3<Real> angular{xx_ * moment.x + xz_ * moment.z,
                             yy_ * (moment.y - coupling_ * (pin * (1.0 / kPinInertia))),
                             zz_ * moment.z + xz_ * moment.x};
    const Real pin_rate = (pin - coupling_ * angular.y) * (1.0 / kPinInertia);

    // d'' gives the acceleration of the base's centre of mass, then that of its origin.
    const Vec3<Real> away{(angular.y * dz + ex * pin_rate) + bias.x,
                          (angular.z * dx - angular.x * dz) + bias.y,
                          (ez * pin_rate - angular.y * dx) + bias.z};
    const Vec3<Real> center = rotors.push * Real(kMass / kAll) - away * Real(kPinRod.mass / kAll);
    return {{{center.x - kCom * (angular.y + w.x * w.z), center.y + kCom * (angular.x - w.y * w.z),
              center.z + kCom * (w.x * w.x + w.y * w.y)},
             angular},
            pin_rate};
  }

 private:
  static constexpr double kAll = kMass + kPinRod.mass, kReduced = kMass * kPinRod.mass / kAll;
  static constexpr double kPinInertia = kPinRod.y + kReduced * kPinRod.arm * kPinRod.arm;

  /// u x (u x (x, 0, z)).
  static SKYBODY_INLINE Vec3<Real> swirl(const Vec3<Real>& u, const Real& x, const Real& z) {
    const Real along = u.x * x + u.z * z, square = (u.x * u.x + u.y * u.y) + u.z * u.z;
    return {u.x * along - x * square, u.y * along, u.z * along - z * square};
  }
  /// The rod's inertia in base axes, times u.
  SKYBODY_INLINE Vec3<Real> rod_inertia(const Vec3<Real>& u) const {
    return {ixx_ * u.x + ixz_ * u.z, kPinRod.y * u.y, ixz_ * u.x + izz_ * u.z};
  }

  Real ixx_, izz_, ixz_;  ///< the rod's inertia in base axes
  Real r1x_, r1z_;        ///< from the pin to the rod's centre of mass
  Real dz_;
  Real coupling_;           ///< between the accelerations of the pin and of the base about y
  Real xx_, xz_, yy_, zz_;  ///< inverse of the base's equations without the pin
};

/// One physics step.
/// @param command  of the rotors, within their limits [rad/s]
template <class Real>
SKYBODY_INLINE void fly(Swinger<Real>& s, const Real* command) {
  const RotorSums<Real> rotors = run_rotors(s.base.rotor, command);
  drift(s.base);
  s.angle += (0.5 * kDt) * s.rate;
  const Mat3<Real> r = to_mat3(s.base.rotation);
  const PinRodPose<Real> pose(s.angle);
  FlyerVelocity<Real> middle(s.base, r);
  const SwingerRates<Real> first = pose.rates(rotors, middle, s.rate);
  middle.kick_half(first.base, r);
  const SwingerRates<Real> second =
      pose.rates(rotors, middle, Real(s.rate + (0.5 * kDt) * first.rate));
  kick(s.base, second.base, r);
  s.rate += kDt * second.rate;
  drift_to_end(s.base);
  s.angle += (0.5 * kDt) * s.rate;
}

}  // namespace skybody::bench::limit
