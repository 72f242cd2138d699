// Rotors of one body with the body's z axis as their axis and hubs at one height. Their forces come
// from sums that are independent of the body's motion. The laws are those of rotor_force.h.
#pragma once

#include "core/base/math/vec3.h"
#include "core/model/state_layout.h"
#include "core/physics/bodies/spatial_force.h"
#include "core/physics/forces/rotor_lag.h"

namespace skybody {

/// A rotor's mounting on its body. The hub position is part of its constants (hub_of).
struct RotorMount {
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

/// Products of a rotor's constants and its hub position, for CoplanarRotors. x, y: hub, body axes.
enum RotorFactor : int {
  kThrustFactor = 0,    ///< 3: k_f, k_f x, k_f y
  kMomentFactor = 3,    ///< s k_m
  kDragFactor = 4,      ///< 4: c_d, c_d x, c_d y, c_d (x^2 + y^2)
  kRollingFactor = 8,   ///< 3: s c_r, s c_r x, s c_r y
  kInertiaFactor = 11,  ///< s J
  kSpeedLimit = 12,     ///< the rotor's own speed limit
  kHeightFactor = 13,   ///< z of the hub
  kRotorFactorCount = 14
};

/// @param constants  the rotor's kRotorParamCount values
/// @param out        kRotorFactorCount values
template <class Constants, class Real>
SKYBODY_INLINE void make_rotor_factors(const Constants& constants, const RotorMount& place,
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
  out[kHeightFactor] = constants[kRotorPosition + 2];
}

/// The lanes in which all hubs are at one height, for rotors whose axes are the body's z axis. Hub
/// positions may be randomized.
/// @param height  height(i): of hub i, from 0 on
template <class Real, class Height>
SKYBODY_INLINE MaskOf<Real> are_level(int count, const Height& height) {
  MaskOf<Real> is_level(true);
  for (int i = 1; i < count; ++i) is_level = logical_and(is_level, height(i) == height(0));
  return is_level;
}

/// Sums of one quantity over four rotors in rows (are_in_rows), with the signs of their hubs'
/// coordinates relative to the first hub.
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

/// Whether the first four rotors are at the corners of a rectangle about the body's z axis, at (x,
/// y), (x, -y), (-x, y) and (-x, -y), and neighbours spin in opposite directions.
bool are_in_rows(const RotorMount* rotors, const double* params);

/// Total force of rotors of one body with the body's z axis as their axis and hubs at one height,
/// from sums over the rotors that are independent of the body's motion.
template <class Real>
class CoplanarRotors {
 public:
  CoplanarRotors() = default;  ///< not set

  /// The first rotor.
  /// @param factors  its kRotorFactorCount values
  /// @param rotor    its acceleration in any unit; force() receives that unit
  template <class Factors>
  SKYBODY_INLINE CoplanarRotors(const Factors& factors, const RotorMotion<Real>& rotor) {
    const Real w = rotor.speed, squared = rotor.squared, size = abs(w);
    for (int k = 0; k < 3; ++k) thrust_[k] = factors[kThrustFactor + k] * squared;
    moment_ = factors[kMomentFactor] * squared;
    for (int k = 0; k < 4; ++k) drag_[k] = factors[kDragFactor + k] * size;
    for (int k = 0; k < 3; ++k) rolling_[k] = factors[kRollingFactor + k] * w;
    momentum_ = factors[kInertiaFactor] * w;
    spin_up_ = factors[kInertiaFactor] * rotor.acceleration;
  }

  /// Four equal rotors in rows, none of which spins backwards. Equal to the general sum up to
  /// round-off, with a third of the operations.
  /// @param factors  of the first rotor
  template <class Factors>
  SKYBODY_INLINE CoplanarRotors(const Factors& factors, const RotorMotion<Real> (&r)[4]) {
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

  /// Adds another rotor.
  SKYBODY_INLINE CoplanarRotors& operator+=(const CoplanarRotors& other) {
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
    // Velocity across the axis, of a hub at x, y: (hub_x - spin_z y, hub_y + spin_z x).
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
  friend SKYBODY_INLINE CoplanarRotors select(const Mask& mask, const CoplanarRotors& a,
                                              const CoplanarRotors& b) {
    CoplanarRotors out;
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
  Real thrust_[3];   ///< k_f w |w| [N], times x, y [N m]
  Real moment_;      ///< s k_m w |w| [N m]
  Real drag_[4];     ///< c_d |w| [N s/m], times x, y, x^2 + y^2
  Real rolling_[3];  ///< s c_r w [N s], times x, y
  Real momentum_;    ///< s J w [kg m^2/s]
  Real spin_up_;     ///< s J dw/dt [N m], over the unit of dw/dt
};

/// Whether four rotors that are nominally in rows have equal constants and are in rows in fact: the
/// precondition of the sum by rows.
/// @param factors  of all rotors, one after another
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
    const auto compare = [&](int k, double sign) SKYBODY_INLINE_LAMBDA {
      alike = logical_and(alike, other[k] == sign * factors[k]);
    };
    for (const int k : {kThrustFactor, kDragFactor}) {
      compare(k + 1, x_sign);
      compare(k + 2, y_sign);
    }
    compare(kRollingFactor + 1, y_sign);  // the direction's sign is x_sign y_sign
    compare(kRollingFactor + 2, x_sign);
  }
  return alike;
}

}  // namespace skybody
