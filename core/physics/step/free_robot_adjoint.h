// Hand-written adjoint of the midpoint rule's step of a free robot with level rotors
// (free_robot_step.h): each phase of the step in reverse order, with the transpose of its
// derivative. On double and packs.
//
// Names: a value `x` of the step has the adjoint `to_x`, the derivative of the scalar objective by
// x. Transposes used: with r = q * b (Hamilton's product), to_q = to_r * conj(b) and to_b = conj(q)
// * to_r; with r = a x b, to_a = b x to_r and to_b = to_r x a.
#pragma once

#include "core/physics/bodies/body_constants.h"
#include "core/physics/forces/coplanar_rotors.h"
#include "core/physics/step/rotation_adjoint.h"
#include "core/physics/world/lane_values.h"

namespace skybody {

/// Sums over the rotors (CoplanarRotors), or their adjoint.
template <class Real>
struct LevelSums {
  Real thrust[3], moment, drag[4], rolling[3], momentum, spin_up;

  SKYBODY_INLINE LevelSums()
      : thrust{Real(0.0), Real(0.0), Real(0.0)},
        moment(0.0),
        drag{Real(0.0), Real(0.0), Real(0.0), Real(0.0)},
        rolling{Real(0.0), Real(0.0), Real(0.0)},
        momentum(0.0),
        spin_up(0.0) {}
};

/// One rotor over the step, by the closed form of its lag.
template <class Real>
struct RotorOverStep {
  Real command, speed, end, decay, half_mean, lacking, squared, mean;
  MaskOf<Real> is_limited;

  SKYBODY_INLINE RotorOverStep(const RotorLag<Real>& lag, const Real& at_start, const Real& wanted,
                               const Real& max_speed)
      : command(limit_command(wanted, max_speed)),
        speed(at_start),
        is_limited(logical_or(wanted<0.0, wanted> max_speed)) {
    const auto rising = command > speed;
    decay = select(rising, lag.up.decay[kStepEnd], lag.down.decay[kStepEnd]);
    half_mean = select(rising, lag.up.half_mean, lag.down.half_mean);
    end = command - (command - speed) * decay;
    lacking = (command - speed) * half_mean;
    mean = command - (lacking + lacking);
    squared = command * command - lacking * ((command + command) + (speed + end));
  }

  /// @param to_end  in: of the speed at the step's end; the gradient through the means is added
  SKYBODY_INLINE void pull_back(const Real& to_squared, const Real& to_mean, const Real& to_change,
                                Real to_end, Real& to_speed, Real& to_command) const {
    to_end += to_change - lacking * to_squared;
    const Real to_lacking =
        -(to_mean + to_mean) - ((command + command) + (speed + end)) * to_squared;
    const Real to_gap = half_mean * to_lacking - decay * to_end;
    to_speed = -to_change - lacking * to_squared - to_gap;
    const Real to_limited =
        to_mean + ((command + command) - (lacking + lacking)) * to_squared + to_end + to_gap;
    to_command = select(is_limited, Real(0.0), to_limited);
  }
};

template <class Real>
struct FreeRobotConstants {
  SymMat3<Real> inertia, inverse_inertia;
  Real inverse_mass, height;
  Vec3<Real> com;
  double unit;  ///< of the rotors' accelerations [rad/s^2]
};

/// The equations of motion of such a robot at one point of its step.
/// @tparam kSpins  with the effect of the body's own spin; otherwise forces only, as for fast lanes
template <class Real, bool kSpins>
class FreeRatesAdjoint {
 public:
  using Constants = FreeRobotConstants<Real>;

  /// @param air   velocity of the origin through the air; @param spin  both in body axes
  SKYBODY_INLINE FreeRatesAdjoint(const Constants& c, const LevelSums<Real>& rotors,
                                  const Vec3<Real>& air, const Vec3<Real>& spin)
      : c_(c), r_(rotors), w_(spin) {
    hub_x_ = air.x + w_.y * c.height;
    hub_y_ = air.y - w_.x * c.height;
    const Vec3<Real> f{w_.z * r_.drag[2] - hub_x_ * r_.drag[0],
                       -(hub_y_ * r_.drag[0] + w_.z * r_.drag[1]), r_.thrust[0]};
    const Real roll_x = hub_x_ * r_.rolling[0] - w_.z * r_.rolling[2];
    const Real roll_y = hub_y_ * r_.rolling[0] + w_.z * r_.rolling[1];
    const Vec3<Real> m{(r_.thrust[2] - c.height * f.y) - (roll_x + w_.y * r_.momentum),
                       (c.height * f.x - r_.thrust[1]) - (roll_y - w_.x * r_.momentum),
                       ((hub_x_ * r_.drag[2] - hub_y_ * r_.drag[1]) - w_.z * r_.drag[3]) -
                           (r_.moment + r_.spin_up * c.unit)};
    Vec3<Real> moment = m - cross(c.com, f);
    if constexpr (kSpins) {
      momentum_ = c.inertia * w_;
      moment -= cross(w_, momentum_);
    }
    spin_rate = c.inverse_inertia * moment;
    in_body = f * c.inverse_mass - cross(spin_rate, c.com);
    if constexpr (kSpins) in_body -= cross(w_, cross(w_, c.com));
  }

  Vec3<Real> in_body;    ///< rate of the velocity without gravity, body axes
  Vec3<Real> spin_rate;  ///< body axes

  /// Adds to to_air, to_spin and to_rotors.
  SKYBODY_INLINE void pull_back(const Vec3<Real>& to_in_body, Vec3<Real> to_spin_rate,
                                Vec3<Real>& to_air, Vec3<Real>& to_spin,
                                LevelSums<Real>& to_rotors) const {
    to_spin_rate -= cross(c_.com, to_in_body);
    const Vec3<Real> to_m = c_.inverse_inertia * to_spin_rate;
    if constexpr (kSpins) {
      to_spin -= cross(cross(w_, c_.com), to_in_body);
      to_spin -= cross(c_.com, cross(to_in_body, w_));
      to_spin -= cross(momentum_, to_m);
      to_spin -= c_.inertia * cross(to_m, w_);
    }
    const Vec3<Real> to_f = to_in_body * c_.inverse_mass - cross(to_m, c_.com);
    pull_back_forces(to_f, to_m, to_air, to_spin, to_rotors);
  }

 private:
  SKYBODY_INLINE void pull_back_forces(Vec3<Real> to_f, const Vec3<Real>& to_m, Vec3<Real>& to_air,
                                       Vec3<Real>& to_spin, LevelSums<Real>& to) const {
    to.thrust[2] += to_m.x;
    to.thrust[1] -= to_m.y;
    to_f.y -= c_.height * to_m.x;
    to_f.x += c_.height * to_m.y;
    to_spin.y -= r_.momentum * to_m.x;
    to_spin.x += r_.momentum * to_m.y;
    to.momentum += w_.x * to_m.y - w_.y * to_m.x;
    to.moment -= to_m.z;
    to.spin_up -= to_m.z * c_.unit;
    to.drag[3] -= w_.z * to_m.z;
    to.drag[2] += hub_x_ * to_m.z + w_.z * to_f.x;
    to.drag[1] -= hub_y_ * to_m.z + w_.z * to_f.y;
    to.drag[0] -= hub_x_ * to_f.x + hub_y_ * to_f.y;
    to.thrust[0] += to_f.z;
    to.rolling[0] -= hub_x_ * to_m.x + hub_y_ * to_m.y;
    to.rolling[1] -= w_.z * to_m.y;
    to.rolling[2] += w_.z * to_m.x;
    const Real to_hub_x = r_.drag[2] * to_m.z - r_.rolling[0] * to_m.x - r_.drag[0] * to_f.x;
    const Real to_hub_y = -(r_.drag[1] * to_m.z) - r_.rolling[0] * to_m.y - r_.drag[0] * to_f.y;
    to_spin.z += (r_.rolling[2] * to_m.x - r_.rolling[1] * to_m.y - r_.drag[3] * to_m.z) +
                 (r_.drag[2] * to_f.x - r_.drag[1] * to_f.y);
    to_air.x += to_hub_x;
    to_air.y += to_hub_y;
    to_spin.y += c_.height * to_hub_x;
    to_spin.x -= c_.height * to_hub_y;
  }

  const Constants& c_;
  const LevelSums<Real>& r_;
  Vec3<Real> w_;
  Vec3<Real> momentum_;
  Real hub_x_, hub_y_;
};

/// A rotation for a time: q * (cosine, sine), both series in the square of half the angle.
template <class Real>
struct RotationIncrement {
  Vec3<Real> half;
  Real square, cosine, sine;  ///< the sine over half the angle
  Real cosine_slope, sine_slope;
  double scale;
  bool stretches;  ///< as integrate_rotation_unnormalized()

  /// As turned(), or integrate_rotation_unnormalized() (bodies/kinematics.h).
  SKYBODY_INLINE RotationIncrement(const Vec3<Real>& spin, double time, bool does_stretch)
      : half(spin * Real(0.5 * time)),
        square(dot(half, half)),
        scale(0.5 * time),
        stretches(does_stretch) {
    if (stretches) {
      cosine = Real(1.0);
      cosine_slope = Real(0.0);
      sine = 1.0 + square * (1.0 / 3 + square * (2.0 / 15));
      sine_slope = 1.0 / 3 + square * (4.0 / 15);
    } else {
      cosine = 1.0 - square * (0.5 - square * (1.0 / 24));
      cosine_slope = square * (1.0 / 12) - 0.5;
      sine = 1.0 - square * (1.0 / 6 - square * (1.0 / 120));
      sine_slope = square * (1.0 / 60) - 1.0 / 6;
    }
  }
  SKYBODY_INLINE Quat<Real> factor() const {
    return {cosine, half.x * sine, half.y * sine, half.z * sine};
  }
  /// Adds to to_spin. @returns the adjoint of the quaternion before
  SKYBODY_INLINE Quat<Real> pull_back(const Quat<Real>& before, const Quat<Real>& to_after,
                                      Vec3<Real>& to_spin) const {
    const Quat<Real> to_factor = conjugate(before) * to_after;
    const Vec3<Real> to_sine{to_factor.x, to_factor.y, to_factor.z};
    const Real along = sine_slope * dot(half, to_sine) + cosine_slope * to_factor.w;
    to_spin += (to_sine * sine + half * (along + along)) * Real(scale);
    return to_after * conjugate(factor());
  }
};

}  // namespace skybody
