// Saturation of thrust and torques by priority.
//
// With P the pseudo-inverse (pseudo_inverse.h), rotor i gives f_i = P_i u within [least_i, full_i];
// least_i is 0, or negative for reversible rotors. A command u within the rotors' limits is
// unchanged. Other commands are reduced in this order:
//   1. roll and pitch torque, both scaled by the largest s <= 1 for which a feasible thrust exists;
//   2. thrust, changed as little as needed to be feasible with these torques;
//   3. yaw torque, scaled by the largest t <= 1 that does not change the thrust further. If the yaw
//      torque allows a thrust nearer to the command, the thrust is moved there.
// A rotor with P_i0 <= 0, which gives no lift, is left out and clamped at its limits.
#pragma once

#include <vector>

#include "controllers/common/robot.h"

namespace skybody::control {

/// A rotor in the allocation.
struct AllocatedRotor {
  double thrust, roll, pitch, yaw;  ///< row of P
  double per_thrust;                ///< 1 / thrust if it lifts
  double least, full;               ///< [N]
  double per_constant;              ///< 1 / kf
  bool lifts;
};

/// Reduces commands to the rotors' limits.
class Priority {
 public:
  using Row = AllocatedRotor;

  /// The reduced command.
  template <class Real>
  struct Shares {
    Real thrust;     ///< [N]
    Real tilt, yaw;  ///< factors on the torques
  };

  explicit Priority(const std::vector<Row>& rotors) : rotors_(rotors) {}

  /// The feasible part of a command.
  template <class Real>
  SKYBODY_INLINE Shares<Real> fitting(const Real& thrust, const Vec3<Real>& torque) const {
    Shares<Real> use{thrust, Real(1.0), Real(1.0)};
    const Real excess = excess_of(use, torque);
    if (any(excess > 0.0)) {
      const Shares<Real> less = cut(thrust, torque);
      use.thrust = select(excess > 0.0, less.thrust, use.thrust);
      use.tilt = select(excess > 0.0, less.tilt, use.tilt);
      use.yaw = select(excess > 0.0, less.yaw, use.yaw);
    }
    return use;
  }

  template <class Real>
  static SKYBODY_INLINE Real tilt_part(const Row& r, const Vec3<Real>& torque) {
    return r.roll * torque.x + r.pitch * torque.y;
  }
  /// Thrust of one rotor [N].
  template <class Real>
  static SKYBODY_INLINE Real push(const Row& r, const Shares<Real>& use, const Vec3<Real>& torque) {
    const Real base = r.thrust * use.thrust + use.tilt * tilt_part(r, torque);
    return base + use.yaw * (r.yaw * torque.z);
  }

 private:
  /// The largest violation of the rotors' limits [N]; at most 0 if the command is feasible.
  template <class Real>
  SKYBODY_INLINE Real excess_of(const Shares<Real>& use, const Vec3<Real>& torque) const {
    Real excess(0.0);
    for (const Row& r : rotors_) {
      if (!r.lifts) continue;
      const Real f = push(r, use, torque);
      excess = max(excess, max(r.least - f, f - r.full));
    }
    return excess;
  }

  /// Steps 1 to 3. Here all values are per unit of the thrust column: rotor i gives L + o_i within
  /// [b_i, c_i], with L the thrust and o_i the part of the torques.
  template <class Real>
  SKYBODY_INLINE Shares<Real> cut(const Real& thrust, const Vec3<Real>& torque) const {
    Shares<Real> use{thrust, tilt_share(torque), Real(0.0)};
    const Real moved = abs(nearest_lift(use, thrust, torque) - thrust);
    use.yaw = yaw_share(use, moved, torque);
    use.thrust = nearest_lift(use, thrust, torque);
    return use;
  }

  template <class Real>
  static SKYBODY_INLINE Real offset(const Row& r, const Shares<Real>& use,
                                    const Vec3<Real>& torque) {
    return (use.tilt * tilt_part(r, torque) + use.yaw * (r.yaw * torque.z)) * r.per_thrust;
  }

  /// The thrust nearest to `wanted` that is feasible with these torques.
  template <class Real>
  SKYBODY_INLINE Real nearest_lift(const Shares<Real>& use, const Real& wanted,
                                   const Vec3<Real>& torque) const {
    Real low(-kLargest), high(kLargest);
    for (const Row& r : rotors_) {
      if (!r.lifts) continue;
      const Real o = offset(r, use, torque);
      low = max(low, r.least * r.per_thrust - o);
      high = min(high, r.full * r.per_thrust - o);
    }
    return clamp(wanted, low, max(low, high));
  }

  /// Step 3: the largest t <= 1 for which a feasible thrust within `moved` of the desired one
  /// exists. @param use  with yaw 0, which is feasible
  template <class Real>
  SKYBODY_INLINE Real yaw_share(const Shares<Real>& use, const Real& moved,
                                const Vec3<Real>& torque) const {
    Real share(1.0);
    // Lowers the factor t so that violation + t growth <= 0, which holds at t = 0.
    const auto limit = [&](const Real& violation, const Real& growth) SKYBODY_INLINE_LAMBDA {
      const Real room = max(-violation, 0.0);
      share = min(share,
                  select(growth > 0.0, room / select(growth > 0.0, growth, Real(1.0)), Real(1.0)));
    };
    for (std::size_t i = 0; i < rotors_.size(); ++i) {
      const Row& r = rotors_[i];
      if (!r.lifts) continue;
      const Real o = offset(r, use, torque), yaw = (r.yaw * torque.z) * r.per_thrust;
      limit((r.least * r.per_thrust - (use.thrust + moved)) - o, -yaw);
      limit(use.thrust - moved + o - r.full * r.per_thrust, yaw);
      for (std::size_t k = i + 1; k < rotors_.size(); ++k) {
        const Row& other = rotors_[k];
        if (!other.lifts) continue;
        // Limits: one rotor at its least thrust, the other at full thrust.
        const Real apart = o - offset(other, use, torque);
        const Real growth = yaw - (other.yaw * torque.z) * other.per_thrust;
        limit(select(growth > 0.0, apart - room(r, other), -apart - room(other, r)), abs(growth));
      }
    }
    return share;
  }

  /// Difference between the full thrust of one rotor and the least thrust of another, per unit of
  /// the thrust column.
  static double room(const Row& high, const Row& low) {
    return high.full * high.per_thrust - low.least * low.per_thrust;
  }

  /// Step 1: the largest s <= 1 for which max_i(b_i - s g_i) <= min_j(c_j - s g_j), with g the tilt
  /// part, b the least and c the full thrust, all per unit of the thrust column.
  template <class Real>
  SKYBODY_INLINE Real tilt_share(const Vec3<Real>& torque) const {
    Real lowest(kLargest);  // of the rotors that are not reversible
    for (const Row& r : rotors_) {
      if (r.lifts && r.least == 0.0) lowest = min(lowest, tilt_part(r, torque) * r.per_thrust);
    }
    Real share(1.0);
    const auto fit = [&](const Real& spread, double space) SKYBODY_INLINE_LAMBDA {
      const auto beyond = spread > space;
      share = min(share, select(beyond, space / select(beyond, spread, Real(1.0)), Real(1.0)));
    };
    for (const Row& r : rotors_) {
      if (!r.lifts) continue;
      const Real part = tilt_part(r, torque) * r.per_thrust;
      fit(part - lowest, r.full * r.per_thrust);
      for (const Row& low : rotors_) {
        if (!low.lifts || low.least == 0.0) continue;
        fit(part - tilt_part(low, torque) * low.per_thrust, room(r, low));
      }
    }
    return share;
  }

  const std::vector<Row>& rotors_;
};

}  // namespace skybody::control
