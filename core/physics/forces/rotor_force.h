// Forces of a spinning rotor on its body. F. Furrer, M. Burri, M. Achtelik, R. Siegwart, "RotorS -
// A modular Gazebo MAV simulator framework", 2016, section "Rotor dynamics", after P. Martin and E.
// Salaun, "The true role of accelerometer feedback in quadrotor control", ICRA 2010. Collective
// thrust and torque of paper eq. 1 are the sums over a robot's rotors.
//
// With w the speed (negative if a reversible rotor spins backwards), n the axis, s = +1 for
// counter-clockwise about n where w > 0, and v' the hub's velocity through the air, across the
// axis:
//   thrust            F = k_f w |w| n
//   reaction          M = -s k_m w |w| n
//   rotor drag        F = -c_d |w| v'
//   rolling moment    M = -s c_r w v'    (RotorS' code omits s; the side of the advancing blade,
//                                         and so the sign, depends on the direction)
//   gyroscopic        M = -omega x (s J w n)
//   spin-up           M = -s J (dw/dt) n
// The last two vanish for rotor inertia J = 0.
#pragma once

#include "core/base/math/vec3.h"
#include "core/model/held_inputs.h"
#include "core/model/state_layout.h"
#include "core/physics/bodies/spatial_force.h"
#include "core/physics/forces/coplanar_rotors.h"
#include "core/physics/forces/rotor_lag.h"
#include "core/physics/world/lane_values.h"

namespace skybody {

/// Gains scale the first of a rotor's constants, in this order.
inline constexpr int kGainedConstants = kHeldInputs[SKYBODY_HELD_ROTOR_GAIN].size;
static_assert(int{kThrustConstant} == SKYBODY_GAIN_THRUST &&
              int{kMomentConstant} == SKYBODY_GAIN_MOMENT &&
              int{kDragConstant} == SKYBODY_GAIN_DRAG &&
              int{kRollingMomentConstant} == SKYBODY_GAIN_ROLLING);

/// A rotor's constants; the first of them are scaled by held gains.
/// @tparam Constants, Gains  pointers, or views
template <class Constants, class Gains>
class ScaledRotorConstants {
 public:
  SKYBODY_INLINE ScaledRotorConstants(const Constants& constants, const Gains& gains)
      : constants_(constants), gains_(gains) {}
  SKYBODY_INLINE auto operator[](int k) const {
    return k < kGainedConstants ? constants_[k] * gains_[k] : constants_[k];
  }

 private:
  Constants constants_;
  Gains gains_;
};

/// Adds one rotor's forces to `sum`. The sum is about the body's origin, but in body axes, unlike
/// other SpatialForces.
/// @param constants  the rotor's kRotorParamCount values
/// @param velocity, spin  of the body's origin [m/s] and body [rad/s], body axes
template <class Real, class Constants>
SKYBODY_INLINE void add_rotor_force(const Constants& constants, const RotorMount& place,
                                    const RotorMotion<Real>& rotor, const Vec3<Real>& velocity,
                                    const Vec3<Real>& spin, SpatialForce<Real>& sum) {
  const Vec3<Real> position = hub_of<Real>(constants), axis = to_real<Real>(place.axis);
  const Real w = rotor.speed, squared = rotor.squared, signed_w = place.direction * w;
  const Vec3<Real> hub = velocity + cross(spin, position);
  const Vec3<Real> across = hub - axis * dot(hub, axis);
  const Vec3<Real> force =
      axis * (constants[kThrustConstant] * squared) - across * (constants[kDragConstant] * abs(w));
  const Real momentum = constants[kRotorInertia] * signed_w;
  const Real about_axis = constants[kMomentConstant] * (place.direction * squared) +
                          constants[kRotorInertia] * (place.direction * rotor.acceleration);
  sum.add_force_at(position, force);
  sum.moment -= across * (constants[kRollingMomentConstant] * signed_w) +
                cross(spin, axis * momentum) + axis * about_axis;
}

/// Consecutive rotors on one body.
struct RotorGroup {
  int body = 0, first = 0, count = 0;
  bool is_level = false;  ///< the nominal mounting allows the sum by CoplanarRotors
};

/// Total force of any group of rotors, summed one by one.
/// @param places     of all rotors of the world
/// @param constants  constants(i): those of rotor i of the world
/// @param motion     motion(i): the motion of rotor i
/// @param unit       of the rotors' accelerations [rad/s^2]
/// @param velocity, spin  of the body's origin through the air [m/s] and body [rad/s], body axes
/// @returns about the body's origin, body axes
template <class Real, class Constants, class Motion>
SKYBODY_INLINE SpatialForce<Real> sum_rotors(const RotorGroup& group, const RotorMount* places,
                                             Constants&& constants, Motion&& motion, double unit,
                                             const Vec3<Real>& velocity, const Vec3<Real>& spin) {
  SpatialForce<Real> sum = SpatialForce<Real>::zero();
  for (int i = group.first; i < group.first + group.count; ++i) {
    const RotorMotion<Real> rotor = motion(i);
    add_rotor_force(constants(i), places[i],
                    RotorMotion<Real>{rotor.speed, rotor.acceleration * unit, rotor.squared},
                    velocity, spin, sum);
  }
  return sum;
}

/// Total force of rotors whose axes are the body's z axis, for lanes with hubs at one height.
template <class Real, class Constants, class Motion>
SKYBODY_INLINE SpatialForce<Real> level_rotor_forces(const RotorGroup& group,
                                                     const RotorMount* places,
                                                     Constants&& constants, Motion&& motion,
                                                     double unit, const Vec3<Real>& velocity,
                                                     const Vec3<Real>& spin) {
  const auto alone = [&](int i) SKYBODY_INLINE_LAMBDA {
    Real factors[kRotorFactorCount];
    make_rotor_factors(constants(i), places[i], factors);
    return CoplanarRotors<Real>(factors, motion(i));
  };
  CoplanarRotors<Real> rotors = alone(group.first);
  for (int i = group.first + 1; i < group.first + group.count; ++i) rotors += alone(i);
  return rotors.force(Real(constants(group.first)[kRotorPosition + 2]), unit, velocity, spin);
}

/// Total force of a group. Uses the faster sum in lanes of a level group whose hubs (which may be
/// randomized) are at one height, otherwise the sum one by one.
template <class Real, class Constants, class Motion>
SKYBODY_INLINE SpatialForce<Real> rotor_forces(const RotorGroup& group, const RotorMount* places,
                                               Constants&& constants, Motion&& motion, double unit,
                                               const Vec3<Real>& velocity, const Vec3<Real>& spin) {
  SpatialForce<Real> level = SpatialForce<Real>::zero();
  MaskOf<Real> is_level(false);
  if (group.is_level) {
    level = level_rotor_forces<Real>(group, places, constants, motion, unit, velocity, spin);
    is_level = are_level<Real>(group.count, [&](int i) SKYBODY_INLINE_LAMBDA {
      return Real(constants(group.first + i)[kRotorPosition + 2]);
    });
    if (all(is_level)) return level;
  }
  return select(is_level, level,
                sum_rotors<Real>(group, places, constants, motion, unit, velocity, spin));
}

/// Further air forces at the hubs, from the held input SkybodyRotorFlow (core/base/held_inputs.h):
/// S. Folk, J. Paulos, V. Kumar, "RotorPy: A Python-based multirotor simulator with aerodynamics
/// for education and research", 2023, section "Rotor aerodynamics".
/// @param params  of the environment: a pointer, or a view
/// @param flow    of all rotors of the world
template <class Real, class Params, class Flow, class Motion>
SKYBODY_INLINE void add_flow_forces(const RotorGroup& group, const RotorMount* places,
                                    const Params& params, const Flow& flow, Motion&& motion,
                                    const Vec3<Real>& velocity, const Vec3<Real>& spin,
                                    SpatialForce<Real>& sum) {
  constexpr int kSize = kHeldInputs[SKYBODY_HELD_ROTOR_FLOW].size;
  for (int i = group.first; i < group.first + group.count; ++i) {
    const Vec3<Real> c{flow[kSize * i + SKYBODY_FLOW_AXIAL_DRAG],
                       flow[kSize * i + SKYBODY_FLOW_FLAPPING],
                       flow[kSize * i + SKYBODY_FLOW_LIFT]};
    const auto any = is_not_zero(c);
    if (none(any)) continue;
    const Vec3<Real> position = hub_of<Real>(params + places[i].params);
    const Vec3<Real> axis = to_real<Real>(places[i].axis);
    const Vec3<Real> hub = velocity + cross(spin, position);
    const Real along = dot(hub, axis), w = motion(i).speed;
    const Vec3<Real> across = hub - axis * along;
    SpatialForce<Real> with = sum;
    with.add_force_at(position, axis * (c.z * dot(across, across) - c.x * (w * along)));
    with.moment -= cross(hub, axis) * (c.y * w);
    sum.force = select(any, with.force, sum.force);  // zero coefficients leave a -0 unchanged
    sum.moment = select(any, with.moment, sum.moment);
  }
}

/// rotor_forces() with the held inputs of the rotors, if any.
/// @param params  of the environment: a pointer, or a view
/// @param held    null: no effects
template <class Real, class Params, class Motion>
SKYBODY_INLINE SpatialForce<Real> held_rotor_forces(const RotorGroup& group,
                                                    const RotorMount* places, const Params& params,
                                                    const HeldLanes<Real>* held, Motion&& motion,
                                                    double unit, const Vec3<Real>& velocity,
                                                    const Vec3<Real>& spin) {
  const auto own = [&](int i) SKYBODY_INLINE_LAMBDA { return params + places[i].params; };
  const auto gained = [&](int i) SKYBODY_INLINE_LAMBDA {
    return ScaledRotorConstants(own(i), (*held)[SKYBODY_HELD_ROTOR_GAIN] + kGainedConstants * i);
  };
  SpatialForce<Real> sum =
      held != nullptr && held->has(SKYBODY_HELD_ROTOR_GAIN)
          ? rotor_forces<Real>(group, places, gained, motion, unit, velocity, spin)
          : rotor_forces<Real>(group, places, own, motion, unit, velocity, spin);
  if (held != nullptr && held->has(SKYBODY_HELD_ROTOR_FLOW)) {
    add_flow_forces<Real>(group, places, params, (*held)[SKYBODY_HELD_ROTOR_FLOW], motion, velocity,
                          spin, sum);
  }
  return sum;
}

}  // namespace skybody
