// What a spinning rotor does to its body. F. Furrer, M. Burri, M. Achtelik, R. Siegwart, "RotorS -
// A modular Gazebo MAV simulator framework", 2016, section "Rotor dynamics", after P. Martin and E.
// Salaun, "The true role of accelerometer feedback in quadrotor control", ICRA 2010. Collective
// thrust and torque of paper eq. 1 are the sums over a robot's rotors.
//
// With w >= 0 the speed, n the axis, s = +1 for counter-clockwise about n, and v' the hub's
// velocity across the axis, through the air:
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
#include "core/model/held_inputs.h"
#include "core/model/layout.h"
#include "core/physics/bodies/spatial_force.h"
#include "core/physics/forces/rotor_lag.h"
#include "core/physics/world/lane_values.h"

namespace skybody {

/// A rotor on its body. Where its hub is, its constants say (hub_of).
struct RotorPlace {
  Vec3<double> axis;       ///< thrust direction, body axes
  double direction = 1.0;  ///< +1 or -1
  int params = 0;          ///< first of its kRotorParamCount values
};

/// A rotor's hub [m], body axes.
/// @param constants  the rotor's kRotorParamCount values
template <class Real, class Constants>
SKYBODY_INLINE Vec3<Real> hub_of(const Constants& constants) {
  return {Real(constants[kRotorPosition]), Real(constants[kRotorPosition + 1]),
          Real(constants[kRotorPosition + 2])};
}

/// Gains act on the first of a rotor's constants, in this order.
inline constexpr int kGainedConstants = kHeldInputs[SKYBODY_HELD_ROTOR_GAIN].size;
static_assert(int{kThrustConstant} == SKYBODY_GAIN_THRUST &&
              int{kMomentConstant} == SKYBODY_GAIN_MOMENT &&
              int{kDragConstant} == SKYBODY_GAIN_DRAG &&
              int{kRollingMomentConstant} == SKYBODY_GAIN_ROLLING);

/// A rotor's constants, the first ones of which effects scale.
/// @tparam Constants, Gains  pointers, or views
template <class Constants, class Gains>
class GainedConstants {
 public:
  SKYBODY_INLINE GainedConstants(const Constants& constants, const Gains& gains)
      : constants_(constants), gains_(gains) {}
  SKYBODY_INLINE auto operator[](int k) const {
    return k < kGainedConstants ? constants_[k] * gains_[k] : constants_[k];
  }

 private:
  Constants constants_;
  Gains gains_;
};

/// Adds one rotor's forces to `sum`, which is about the body's origin like any SpatialForce but in
/// the axes of the body.
/// @param constants  the rotor's kRotorParamCount values
/// @param velocity, spin  of the body's origin [m/s] and body [rad/s], body axes
template <class Real, class Constants>
SKYBODY_INLINE void add_rotor_force(const Constants& constants, const RotorPlace& place,
                                    const RotorMotion<Real>& rotor, const Vec3<Real>& velocity,
                                    const Vec3<Real>& spin, SpatialForce<Real>& sum) {
  const Vec3<Real> position = hub_of<Real>(constants), axis = to_real<Real>(place.axis);
  const Real w = rotor.speed, squared = rotor.squared, signed_w = place.direction * w;
  const Vec3<Real> hub = velocity + cross(spin, position);
  const Vec3<Real> across = hub - axis * dot(hub, axis);
  const Vec3<Real> force =
      axis * (constants[kThrustConstant] * squared) - across * (constants[kDragConstant] * w);
  const Real momentum = constants[kRotorInertia] * signed_w;
  const Real about_axis = constants[kMomentConstant] * (place.direction * squared) +
                          constants[kRotorInertia] * (place.direction * rotor.acceleration);
  sum.add_force_at(position, force);
  sum.moment -= across * (constants[kRollingMomentConstant] * signed_w) +
                cross(spin, axis * momentum) + axis * about_axis;
}

/// A rotor's constants times its place: what LevelRotors ask of it. [x], [y]: hub, body axes.
enum RotorFactor : int {
  kThrustFactor = 0,    ///< 3: k_f, k_f x, k_f y
  kMomentFactor = 3,    ///< s k_m
  kDragFactor = 4,      ///< 4: c_d, c_d x, c_d y, c_d (x^2 + y^2)
  kRollingFactor = 8,   ///< 3: s c_r, s c_r x, s c_r y
  kInertiaFactor = 11,  ///< s J
  kSpeedLimit = 12,     ///< the rotor's own, as it is
  kHubFactor = 13,      ///< 3: x, y, z of the hub, as they are
  kRotorFactorCount = 16
};

/// @param constants  the rotor's kRotorParamCount values
/// @param out        kRotorFactorCount values
template <class Constants, class Real>
SKYBODY_INLINE void make_rotor_factors(const Constants& constants, const RotorPlace& place,
                                       Real* out) {
  const Vec3<Real> hub = hub_of<Real>(constants);
  const Real &x = hub.x, &y = hub.y;
  const Real thrust = constants[kThrustConstant], drag = constants[kDragConstant];
  const Real rolling = constants[kRollingMomentConstant] * place.direction;
  out[kThrustFactor] = thrust;
  out[kThrustFactor + 1] = thrust * x;
  out[kThrustFactor + 2] = thrust * y;
  out[kMomentFactor] = constants[kMomentConstant] * place.direction;
  out[kDragFactor] = drag;
  out[kDragFactor + 1] = drag * x;
  out[kDragFactor + 2] = drag * y;
  out[kDragFactor + 3] = drag * (x * x + y * y);
  out[kRollingFactor] = rolling;
  out[kRollingFactor + 1] = rolling * x;
  out[kRollingFactor + 2] = rolling * y;
  out[kInertiaFactor] = constants[kRotorInertia] * place.direction;
  out[kSpeedLimit] = constants[kMaxSpeed];
  for (int k = 0; k < 3; ++k) out[kHubFactor + k] = constants[kRotorPosition + k];
}

/// A rotor's factors, scaled by what effects hold of its constants.
/// @tparam Factors, Gains  pointers, or views
template <class Factors, class Gains>
class GainedFactors {
 public:
  SKYBODY_INLINE GainedFactors(const Factors& factors, const Gains& gains)
      : factors_(factors), gains_(gains) {}
  SKYBODY_INLINE auto operator[](int k) const {
    return k < kInertiaFactor ? factors_[k] * gains_[gain_of(k)] : factors_[k];
  }

 private:
  static constexpr int gain_of(int k) {
    return k < kMomentFactor    ? SKYBODY_GAIN_THRUST
           : k < kDragFactor    ? SKYBODY_GAIN_MOMENT
           : k < kRollingFactor ? SKYBODY_GAIN_DRAG
                                : SKYBODY_GAIN_ROLLING;
  }

  Factors factors_;
  Gains gains_;
};

/// One quantity of four rotors in rows (are_in_rows), added up with the signs that coordinates of
/// their hubs have beside the first one's.
template <class Real>
struct RowSums {
  Real all, x, y, xy;

  SKYBODY_INLINE RowSums(const Real& a, const Real& b, const Real& c, const Real& d) {
    const Real front = a + b, back = c + d, front_change = a - b, back_change = c - d;
    all = front + back;
    x = front - back;
    y = front_change + back_change;
    xy = front_change - back_change;
  }
};

/// Whether the first four places are the corners of a rectangle about the body's z axis, at (x, y),
/// (x, -y), (-x, y) and (-x, -y), and neighbours turn against each other.
/// @param params  of the environment
bool are_in_rows(const RotorPlace* rotors, const double* params);

/// Rotors of one body with the body's z as their axis and their hubs at one height: what they do
/// together, from sums over the rotors that know nothing of the body's motion.
template <class Real>
class LevelRotors {
 public:
  LevelRotors() = default;  ///< not set

  /// The first rotor.
  /// @param factors  its kRotorFactorCount values
  /// @param rotor    its acceleration in any unit that force() is told
  template <class Factors>
  SKYBODY_INLINE LevelRotors(const Factors& factors, const RotorMotion<Real>& rotor) {
    const Real w = rotor.speed, squared = rotor.squared;
    for (int k = 0; k < 3; ++k) thrust_[k] = factors[kThrustFactor + k] * squared;
    moment_ = factors[kMomentFactor] * squared;
    for (int k = 0; k < 4; ++k) drag_[k] = factors[kDragFactor + k] * w;
    for (int k = 0; k < 3; ++k) rolling_[k] = factors[kRollingFactor + k] * w;
    momentum_ = factors[kInertiaFactor] * w;
    spin_up_ = factors[kInertiaFactor] * rotor.acceleration;
  }

  /// Four rotors alike, in rows: the same up to rounding, with a third of the operations.
  /// @param factors  of the first
  template <class Factors>
  SKYBODY_INLINE LevelRotors(const Factors& factors, const RotorMotion<Real> (&r)[4]) {
    const RowSums<Real> squared(r[0].squared, r[1].squared, r[2].squared, r[3].squared);
    const RowSums<Real> w(r[0].speed, r[1].speed, r[2].speed, r[3].speed);
    thrust_[0] = factors[kThrustFactor] * squared.all;
    thrust_[1] = factors[kThrustFactor + 1] * squared.x;
    thrust_[2] = factors[kThrustFactor + 2] * squared.y;
    moment_ = factors[kMomentFactor] * squared.xy;
    drag_[0] = factors[kDragFactor] * w.all;
    drag_[1] = factors[kDragFactor + 1] * w.x;
    drag_[2] = factors[kDragFactor + 2] * w.y;
    drag_[3] = factors[kDragFactor + 3] * w.all;
    rolling_[0] = factors[kRollingFactor] * w.xy;
    rolling_[1] = factors[kRollingFactor + 1] * w.y;  // the sign of the direction, times that of x
    rolling_[2] = factors[kRollingFactor + 2] * w.x;
    momentum_ = factors[kInertiaFactor] * w.xy;
    spin_up_ = factors[kInertiaFactor] *
               ((r[0].acceleration - r[1].acceleration) - (r[2].acceleration - r[3].acceleration));
  }

  /// Another rotor.
  SKYBODY_INLINE LevelRotors& operator+=(const LevelRotors& other) {
    for (int k = 0; k < 3; ++k) thrust_[k] += other.thrust_[k];
    moment_ += other.moment_;
    for (int k = 0; k < 4; ++k) drag_[k] += other.drag_[k];
    for (int k = 0; k < 3; ++k) rolling_[k] += other.rolling_[k];
    momentum_ += other.momentum_;
    spin_up_ += other.spin_up_;
    return *this;
  }

  /// @param height  of the hubs above the body's origin [m]
  /// @param unit    of the accelerations [rad/s^2]
  /// @param velocity, spin  as for add_rotor_force
  /// @returns about the body's origin, body axes
  SKYBODY_INLINE SpatialForce<Real> force(const Real& height, double unit,
                                          const Vec3<Real>& velocity,
                                          const Vec3<Real>& spin) const {
    // Velocity across the axis of a hub at x, y: (hub_x - spin_z y, hub_y + spin_z x).
    const Real hub_x = velocity.x + spin.y * height, hub_y = velocity.y - spin.x * height;
    const Vec3<Real> f{spin.z * drag_[2] - hub_x * drag_[0],
                       -(hub_y * drag_[0] + spin.z * drag_[1]), thrust_[0]};
    const Real roll_x = hub_x * rolling_[0] - spin.z * rolling_[2];
    const Real roll_y = hub_y * rolling_[0] + spin.z * rolling_[1];
    return {
        {(thrust_[2] - height * f.y) - (roll_x + spin.y * momentum_),
         (height * f.x - thrust_[1]) - (roll_y - spin.x * momentum_),
         ((hub_x * drag_[2] - hub_y * drag_[1]) - spin.z * drag_[3]) - (moment_ + spin_up_ * unit)},
        f};
  }

  /// `a` where the mask is set, else `b`.
  template <class Mask>
  friend SKYBODY_INLINE LevelRotors select(const Mask& mask, const LevelRotors& a,
                                           const LevelRotors& b) {
    LevelRotors out;
    const auto choose = [&](const auto& from_a, const auto& from_b, auto& to)
                            SKYBODY_INLINE_LAMBDA {
                              for (std::size_t k = 0; k < std::size(to); ++k)
                                to[k] = select(mask, from_a[k], from_b[k]);
                            };
    choose(a.thrust_, b.thrust_, out.thrust_);
    choose(a.drag_, b.drag_, out.drag_);
    choose(a.rolling_, b.rolling_, out.rolling_);
    out.moment_ = select(mask, a.moment_, b.moment_);
    out.momentum_ = select(mask, a.momentum_, b.momentum_);
    out.spin_up_ = select(mask, a.spin_up_, b.spin_up_);
    return out;
  }

 private:
  Real thrust_[3];   ///< k_f w^2 [N], times x, y [N m]
  Real moment_;      ///< s k_m w^2 [N m]
  Real drag_[4];     ///< c_d w [N s/m], times x, y, x^2 + y^2
  Real rolling_[3];  ///< s c_r w [N s], times x, y
  Real momentum_;    ///< s J w [kg m^2/s]
  Real spin_up_;     ///< s J dw/dt [N m], over the unit of dw/dt
};

/// Whether four rotors that are nominally in rows have equal constants, and are in rows.
/// @param factors  of all, one after another
template <class Factors>
SKYBODY_INLINE auto are_alike(const Factors& factors) {
  auto alike = factors[kThrustFactor] == factors[kThrustFactor];
  for (int rotor = 1; rotor < 4; ++rotor) {
    const auto other = factors + kRotorFactorCount * rotor;
    for (const int k :
         {kThrustFactor, kMomentFactor, kDragFactor, kRollingFactor, kInertiaFactor}) {
      alike = logical_and(alike, abs(other[k]) == abs(factors[k]));
    }
    const double x_sign = rotor == 1 ? 1.0 : -1.0, y_sign = rotor == 2 ? 1.0 : -1.0;
    alike = logical_and(alike, other[kHubFactor] == x_sign * factors[kHubFactor]);
    alike = logical_and(alike, other[kHubFactor + 1] == y_sign * factors[kHubFactor + 1]);
  }
  return alike;
}

/// Consecutive rotors on one body.
struct RotorGroup {
  int body = 0, first = 0, count = 0;
  bool is_level = false;  ///< by the nominal places they go as LevelRotors
};

/// What the rotors of any group do to their body, one by one.
/// @param places     of all rotors of the world
/// @param constants  constants(i): those of rotor i of the world
/// @param motion     motion(i) says how it moves
/// @param unit       of the rotors' accelerations [rad/s^2]
/// @param velocity, spin  of the body's origin through the air [m/s] and body [rad/s], body axes
/// @returns about the body's origin, body axes
template <class Real, class Constants, class Motion>
SKYBODY_INLINE SpatialForce<Real> sum_rotors(const RotorGroup& group, const RotorPlace* places,
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

/// Rotors whose axes are the body's z, where their hubs are at one height.
template <class Real, class Constants, class Motion>
SKYBODY_INLINE SpatialForce<Real> level_rotor_forces(const RotorGroup& group,
                                                     const RotorPlace* places,
                                                     Constants&& constants, Motion&& motion,
                                                     double unit, const Vec3<Real>& velocity,
                                                     const Vec3<Real>& spin) {
  const auto alone = [&](int i) SKYBODY_INLINE_LAMBDA {
    Real factors[kRotorFactorCount];
    make_rotor_factors(constants(i), places[i], factors);
    return LevelRotors<Real>(factors, motion(i));
  };
  LevelRotors<Real> rotors = alone(group.first);
  for (int i = group.first + 1; i < group.first + group.count; ++i) rotors += alone(i);
  return rotors.force(Real(constants(group.first)[kRotorPosition + 2]), unit, velocity, spin);
}

/// The same by the quicker way in lanes that have one: of a level group those whose hubs, which may
/// be drawn, are at one height.
template <class Real, class Constants, class Motion>
SKYBODY_INLINE SpatialForce<Real> rotor_forces(const RotorGroup& group, const RotorPlace* places,
                                               Constants&& constants, Motion&& motion, double unit,
                                               const Vec3<Real>& velocity, const Vec3<Real>& spin) {
  SpatialForce<Real> level = SpatialForce<Real>::zero();
  MaskOf<Real> is_level(false);
  if (group.is_level) {
    const auto height = [&](int i) SKYBODY_INLINE_LAMBDA {
      return Real(constants(i)[kRotorPosition + 2]);
    };
    level = level_rotor_forces<Real>(group, places, constants, motion, unit, velocity, spin);
    is_level = MaskOf<Real>(true);
    for (int i = 1; i < group.count; ++i) {
      is_level = logical_and(is_level, height(group.first + i) == height(group.first));
    }
    if (all(is_level)) return level;
  }
  return select(is_level, level,
                sum_rotors<Real>(group, places, constants, motion, unit, velocity, spin));
}

/// What the air at the hubs does besides, where effects hold it (core/base/held_inputs.h,
/// SkybodyRotorFlow): S. Folk, J. Paulos, V. Kumar, "RotorPy: A Python-based multirotor simulator
/// with aerodynamics for education and research", 2023, section "Rotor aerodynamics".
/// @param params  of the environment: a pointer, or a view
/// @param flow    of all rotors of the world
template <class Real, class Params, class Flow, class Motion>
SKYBODY_INLINE void add_flow_forces(const RotorGroup& group, const RotorPlace* places,
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
    sum.force = select(any, with.force, sum.force);  // what is neutral leaves a -0 as it is
    sum.moment = select(any, with.moment, sum.moment);
  }
}

/// The same as rotor_forces() with what effects hold of the rotors, if there are any.
/// @param params  of the environment: a pointer, or a view
/// @param held    null: no effects
template <class Real, class Params, class Motion>
SKYBODY_INLINE SpatialForce<Real> held_rotor_forces(const RotorGroup& group,
                                                    const RotorPlace* places, const Params& params,
                                                    const HeldLanes<Real>* held, Motion&& motion,
                                                    double unit, const Vec3<Real>& velocity,
                                                    const Vec3<Real>& spin) {
  const auto own = [&](int i) SKYBODY_INLINE_LAMBDA { return params + places[i].params; };
  const auto gained = [&](int i) SKYBODY_INLINE_LAMBDA {
    return GainedConstants(own(i), (*held)[SKYBODY_HELD_ROTOR_GAIN] + kGainedConstants * i);
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
