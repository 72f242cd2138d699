// The QDrone2 of scenarios/models/qdrone2 for the limit loops: everything independent of the state
// is a compile-time constant. SI units, body axes x forward, y left, z up, origin of the base link.
#pragma once

namespace skybody::bench::limit {

namespace detail {

/// e^x for |x| <= 0.5 by its series: a constant expression, which the library's exp is not.
constexpr double exp_near_zero(double x) {
  double sum = 1.0, term = 1.0;
  for (int k = 1; k <= 20; ++k) {
    term *= x / k;
    sum += term;
  }
  return sum;
}

}  // namespace detail

constexpr double kDt = 0.001;           ///< physics step [s]
constexpr double kGravity = 9.81;       ///< [m/s^2]
constexpr double kHalfLength = 0.1016;  ///< rotor hubs at x = +-, [m]
constexpr double kHalfWidth = 0.127;    ///< and y = +- [m]
constexpr double kHubHeight = 0.023;    ///< and z [m]

constexpr double kThrust = 1.9533e-6;      ///< k_f [N s^2/rad^2]
constexpr double kMoment = 2.8401e-8;      ///< k_m [N m s^2/rad^2]
constexpr double kDrag = 2.0673e-5;        ///< c_d [N s^2/(m rad)]
constexpr double kRolling = 1e-9;          ///< c_r [N s^2/rad]
constexpr double kRotorInertia = 4.92e-6;  ///< J [kg m^2]
constexpr double kMaxRotorSpeed = 2246.0;  ///< [rad/s]

/// Fraction of the gap to its command that a rotor closes in a step, and half the mean over the
/// step of the fraction that remains, (tau / 2 dt) (1 - exp(-dt / tau)).
constexpr double kRise = 1.0 - detail::exp_near_zero(-kDt / 0.0125);
constexpr double kRiseLack = 0.5 * 0.0125 / kDt * kRise;
constexpr double kFall = 1.0 - detail::exp_near_zero(-kDt / 0.025);
constexpr double kFallLack = 0.5 * 0.025 / kDt * kFall;

// The base and four rotors of 5 g, merged by the parallel-axis theorem.
constexpr double kRotorMass = 0.005, kBaseMass = 1.52;
constexpr double kMass = kBaseMass + 4.0 * kRotorMass;          ///< [kg]
constexpr double kCom = 4.0 * kRotorMass * kHubHeight / kMass;  ///< z of the centre of mass [m]
constexpr double kRotorArmZ = kHubHeight - kCom;                ///< hubs above it [m]
constexpr double kAcrossX = kBaseMass * kCom * kCom + 4.0 * kRotorMass * kRotorArmZ *
                                                          kRotorArmZ;  ///< from moving masses in z
/// About the centre of mass; the other products are zero [kg m^2].
constexpr double kInertiaX =
    0.014387 + 4.0 * 2.46e-6 + kAcrossX + 4.0 * kRotorMass * kHalfWidth * kHalfWidth;
constexpr double kInertiaY =
    0.01656 + 4.0 * 2.46e-6 + kAcrossX + 4.0 * kRotorMass * kHalfLength * kHalfLength;
constexpr double kInertiaZ =
    0.028785 + 4.0 * 4.92e-6 +
    4.0 * kRotorMass * (kHalfLength * kHalfLength + kHalfWidth * kHalfWidth);

}  // namespace skybody::bench::limit
