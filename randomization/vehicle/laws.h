// Scaling laws: a quadrotor's constants from a few quantities. Equations: README.md.
#pragma once

#include "core/base/constants.h"
#include "core/base/math/math.h"
#include "randomization/vehicle/ranges.h"

namespace skybody::randomization {

inline constexpr double kAirDensity = 1.225;  // [kg/m^3], standard atmosphere at sea level

/// Common constants of a vehicle's rotors.
template <class Real>
struct VehicleRotors {
  Real arm, sweep;
  Real constants[SKYBODY_ROTOR_POSITION];  ///< indexed by SkybodyRotorConstant
};

/// The laws for one set of quantities.
/// @tparam At   at(VehicleQuantity): value of a quantity
/// @tparam Has  has(VehicleQuantity): whether it is used, among alternatives
template <class Real, class At, class Has>
struct VehicleLaws {
  const At& at;
  const Has& has;

  /// Moment of inertia about x [kg m^2].
  /// @param full  thrust of one rotor at its largest speed [N]
  SKYBODY_INLINE Real roll_inertia(const Real& mass, const Real& ratio, const Real& full,
                                   const Real& arm) const {
    if (has(kGyration)) {
      const Real radius = at(kGyration) * arm;
      return mass * (radius * radius);
    }
    // Two rotors of an X act with a lever arm of arm / sqrt(2) each.
    const Real torque = arm * full * sqrt(2.0);
    if (has(kTorqueToInertia)) return torque / at(kTorqueToInertia);
    return torque * at(kWeightByTurn) / ratio;
  }

  /// Fills `constants`. @param growth  growth factor of time constants with mass
  SKYBODY_INLINE void make_rotors(const Real& growth, const Real& full, const Real& ratio,
                                  VehicleRotors<Real>& out) const {
    const Real radius = at(kRotorRadius) * out.arm;
    const Real squared = radius * radius;
    // rho C_T n^2 D^4 with n = w / (2 pi), D = 2 R.
    const Real thrust =
        at(kThrustCoefficient) * (squared * squared) * (16.0 * kAirDensity / (kTwoPi * kTwoPi));
    const Real moment_arm = has(kMomentArm) ? at(kMomentArm) : at(kMomentByRadius) * radius;
    const Real up = at(kTauUp);
    const Real down = has(kTauDown) ? at(kTauDown) : at(kTauDownByUp) * up;
    out.constants[SKYBODY_ROTOR_THRUST_CONSTANT] = thrust;
    out.constants[SKYBODY_ROTOR_MOMENT_CONSTANT] = thrust * moment_arm;
    out.constants[SKYBODY_ROTOR_DRAG_CONSTANT] = at(kRotorDrag) * thrust / radius;
    out.constants[SKYBODY_ROTOR_ROLLING_MOMENT_CONSTANT] = at(kRolling) * thrust;
    const Real hover_speed = sqrt(full / (ratio * thrust));
    out.constants[SKYBODY_ROTOR_INERTIA] =
        2.0 * at(kSpinDown) * growth * (thrust * moment_arm) * hover_speed;
    out.constants[SKYBODY_ROTOR_MAX_SPEED] = sqrt(full / thrust);
    out.constants[SKYBODY_ROTOR_TAU_UP] = up * growth;
    out.constants[SKYBODY_ROTOR_TAU_DOWN] = down * growth;
  }
};

}  // namespace skybody::randomization
