// Collective thrust and body torque from and to rotor thrusts.
//
// Needs: rotors fixed to the base. Rotor i at r_i pushes f_i along a_i and gives
//   F_z = a_iz f_i,   tau = ((r_i - c) x a_i - d_i (km_i / kf_i) a_i) f_i,
// c the base's centre of mass, d_i its sense of rotation: u = A f, with u = (F_z, tau). The
// allocation is f = P u with P = A^T (A A^T)^-1, the solution of least norm; sideways forces of
// tilted rotors are not controlled.
//
// A command that the rotors can meet is met. Others are reduced in this order, so that
// 0 <= f_i <= full_i:
//   1. roll and pitch torque, both scaled by the largest s <= 1 for which some thrust fits;
//   2. thrust, moved as little as needed to fit on top of it;
//   3. yaw torque, scaled by the largest t <= 1 that moves thrust no further; where it lets thrust
//      come nearer to what is asked for, thrust does.
// A rotor that does not serve thrust (P_i0 <= 0) takes no part in this and is cut at its limits.
#pragma once

#include <string>
#include <vector>

#include "controllers/common/robot.h"

namespace skybody::control {

/// Thrust along z [N] and torque [N m] of one newton of one rotor, base axes.
struct RotorEffect {
  double thrust;
  Vec3<double> torque;
};

inline RotorEffect effect_of(const RotorInfo& rotor, const BodyInfo& base) {
  const Vec3<double> axis = vec3(rotor.axis);
  const Vec3<double> arm = vec3(rotor.position) - vec3(base.com);
  const double reaction = -rotor.direction * rotor.constants[SKYBODY_ROTOR_MOMENT_CONSTANT] /
                          rotor.constants[SKYBODY_ROTOR_THRUST_CONSTANT];
  return {axis.z, cross(arm, axis) + axis * reaction};
}

/// What the rotors can do together: sum of full thrusts along z, and per axis the torque that is
/// reachable in both senses.
struct ThrustTorqueLimits {
  double thrust = 0.0;                 ///< [N]
  Vec3<double> torque{0.0, 0.0, 0.0};  ///< [N m]
};

inline ThrustTorqueLimits limits_of(const View<RotorInfo>& rotors, const BodyInfo& base) {
  double thrust = 0.0;
  Vec3<double> up{0.0, 0.0, 0.0}, down{0.0, 0.0, 0.0};
  for (const RotorInfo& rotor : rotors) {
    const RotorEffect e = effect_of(rotor, base);
    const double full = full_thrust(rotor);
    thrust += max(0.0, e.thrust * full);
    const Vec3<double> t = e.torque * full;
    up += {max(0.0, t.x), max(0.0, t.y), max(0.0, t.z)};
    down += {max(0.0, -t.x), max(0.0, -t.y), max(0.0, -t.z)};
  }
  return {thrust, {min(up.x, down.x), min(up.y, down.y), min(up.z, down.z)}};
}

/// The pseudo-inverse of one robot and its limits. Immutable after configure().
class Allocation {
 public:
  /// @throws std::runtime_error where thrust and torques are not all reachable
  void configure(const Setup& setup, int robot, const std::string& mode) {
    const View<RotorInfo> rotors = working_rotors(setup, robot, mode);
    const BodyInfo& base = setup.bodies()[base_of(setup, robot)];
    const std::string name = robot_name(setup, robot);
    if (rotors.size() < 4) {
      throw std::runtime_error("robot `" + name + "` has " + std::to_string(rotors.size()) +
                               " rotors; " + mode + " needs 4 or more: use controller `srt`");
    }
    std::vector<double> rows;  // N x 4
    for (const RotorInfo& rotor : rotors) {
      if (rotor.body != base_of(setup, robot)) {
        throw std::runtime_error("rotor `" + std::string(rotor.name) +
                                 "` sits behind a joint, on `" + setup.bodies()[rotor.body].name +
                                 "`; " + mode +
                                 " needs rotors fixed to the base: use controller `srt`");
      }
      const RotorEffect e = effect_of(rotor, base);
      rows.insert(rows.end(), {e.thrust, e.torque.x, e.torque.y, e.torque.z});
    }
    const std::vector<double> inverse = invert(rows, name, mode);
    for (int i = 0; i < rotors.size(); ++i) {
      const double* p = &inverse[static_cast<std::size_t>(4 * i)];
      const bool lifts = p[0] * rotors.size() > 1e-6;
      rotors_.push_back({p[0], p[1], p[2], p[3], lifts ? 1.0 / p[0] : 0.0, full_thrust(rotors[i]),
                         1.0 / rotors[i].constants[SKYBODY_ROTOR_THRUST_CONSTANT], lifts});
    }
  }

  int rotor_count() const { return static_cast<int>(rotors_.size()); }

  /// Writes rotor thrusts [N], saturated as described above.
  template <class Real>
  SKYBODY_INLINE void thrusts(const Real& thrust, const Vec3<Real>& torque,
                              Values<Real> output) const {
    Shares<Real> use{thrust, Real(1.0), Real(1.0)};
    const Real excess = excess_of(use, torque);
    if (any(excess > 0.0)) {
      const Shares<Real> less = cut(thrust, torque);
      use.thrust = select(excess > 0.0, less.thrust, use.thrust);
      use.tilt = select(excess > 0.0, less.tilt, use.tilt);
      use.yaw = select(excess > 0.0, less.yaw, use.yaw);
    }
    for (int i = 0; i < rotor_count(); ++i) {
      const Row& r = rotors_[static_cast<std::size_t>(i)];
      output.set(i, clamp(push(r, use, torque), Real(0.0), Real(r.full)));
    }
  }

  /// The same as rotor speeds [rad/s].
  template <class Real>
  SKYBODY_INLINE void speeds(const Real& thrust, const Vec3<Real>& torque,
                             Values<Real> output) const {
    thrusts(thrust, torque, output);
    for (int i = 0; i < rotor_count(); ++i) {
      output.set(i, sqrt(output[i] * rotors_[static_cast<std::size_t>(i)].per_constant));
    }
  }

 private:
  struct Row {
    double thrust, roll, pitch, yaw;  ///< row of P
    double per_thrust;                ///< 1 / thrust where it lifts
    double full;                      ///< [N]
    double per_constant;              ///< 1 / kf
    bool lifts;
  };

  /// What is left of a command.
  template <class Real>
  struct Shares {
    Real thrust;     ///< [N]
    Real tilt, yaw;  ///< shares of the torques
  };

  template <class Real>
  static SKYBODY_INLINE Real tilt_part(const Row& r, const Vec3<Real>& torque) {
    return r.roll * torque.x + r.pitch * torque.y;
  }
  /// Of one rotor [N].
  template <class Real>
  static SKYBODY_INLINE Real push(const Row& r, const Shares<Real>& use, const Vec3<Real>& torque) {
    const Real base = r.thrust * use.thrust + use.tilt * tilt_part(r, torque);
    return base + use.yaw * (r.yaw * torque.z);
  }

  /// By how much the rotors would leave their limits at most [N]; 0 or less where all is met.
  template <class Real>
  SKYBODY_INLINE Real excess_of(const Shares<Real>& use, const Vec3<Real>& torque) const {
    Real excess(0.0);
    for (const Row& r : rotors_) {
      if (!r.lifts) continue;
      const Real f = push(r, use, torque);
      excess = max(excess, max(-f, f - r.full));
    }
    return excess;
  }

  /// Steps 1 to 3. All is per unit of the thrust column here: rotor i pushes L + o_i out of 0 to
  /// c_i, with L the thrust and o_i what the torques ask for.
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

  /// The thrust nearest to `wanted` on which the torques fit.
  template <class Real>
  SKYBODY_INLINE Real nearest_lift(const Shares<Real>& use, const Real& wanted,
                                   const Vec3<Real>& torque) const {
    Real low(-kLargest), high(kLargest);
    for (const Row& r : rotors_) {
      if (!r.lifts) continue;
      const Real o = offset(r, use, torque);
      low = max(low, -o);
      high = min(high, r.full * r.per_thrust - o);
    }
    return clamp(wanted, low, max(low, high));
  }

  /// Step 3: the largest t <= 1 for which some thrust within `moved` of the one that is asked for
  /// fits. @param use  with yaw 0, which fits
  template <class Real>
  SKYBODY_INLINE Real yaw_share(const Shares<Real>& use, const Real& moved,
                                const Vec3<Real>& torque) const {
    Real share(1.0);
    // Lowers the share t to what keeps violation + t growth at 0 or below, as it is at t = 0.
    const auto limit = [&](const Real& violation, const Real& growth) SKYBODY_INLINE_LAMBDA {
      const Real room = max(-violation, 0.0);
      share = min(share,
                  select(growth > 0.0, room / select(growth > 0.0, growth, Real(1.0)), Real(1.0)));
    };
    for (const Row& r : rotors_) {
      if (!r.lifts) continue;
      const Real o = offset(r, use, torque), yaw = (r.yaw * torque.z) * r.per_thrust;
      limit(-(use.thrust + moved) - o, -yaw);
      limit(use.thrust - moved + o - r.full * r.per_thrust, yaw);
      for (const Row& other : rotors_) {  // between 0 of that one and the full thrust of this one
        if (!other.lifts) continue;
        limit(o - offset(other, use, torque) - r.full * r.per_thrust,
              yaw - (other.yaw * torque.z) * other.per_thrust);
      }
    }
    return share;
  }

  /// Step 1: the largest s <= 1 for which max_i(-s g_i) <= min_j(c_j - s g_j), with g the tilt part
  /// and c the full thrust, both per unit of the thrust column.
  template <class Real>
  SKYBODY_INLINE Real tilt_share(const Vec3<Real>& torque) const {
    Real lowest(kLargest);
    for (const Row& r : rotors_) {
      if (r.lifts) lowest = min(lowest, tilt_part(r, torque) * r.per_thrust);
    }
    Real share(1.0);
    for (const Row& r : rotors_) {
      if (!r.lifts) continue;
      const Real spread = tilt_part(r, torque) * r.per_thrust - lowest;
      const Real room(r.full * r.per_thrust);
      share = min(
          share, select(spread > room, room / select(spread > room, spread, Real(1.0)), Real(1.0)));
    }
    return share;
  }

  /// P, N x 4, from the rows of A^T. Each of the four directions is scaled to length 1 first.
  static std::vector<double> invert(const std::vector<double>& rows, const std::string& robot,
                                    const std::string& mode) {
    static const char* const kNames[4] = {"thrust along z", "roll torque", "pitch torque",
                                          "yaw torque"};
    const std::size_t n = rows.size() / 4;
    double scale[4], m[4][8] = {};
    for (std::size_t k = 0; k < 4; ++k) {
      double sum = 0.0;
      for (std::size_t i = 0; i < n; ++i) sum += rows[4 * i + k] * rows[4 * i + k];
      if (!(sum > 1e-18)) refuse(robot, mode, kNames[k]);
      scale[k] = 1.0 / sqrt(sum);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      for (std::size_t l = 0; l < 4; ++l) {
        for (std::size_t i = 0; i < n; ++i) {
          m[k][l] += (rows[4 * i + k] * scale[k]) * (rows[4 * i + l] * scale[l]);
        }
      }
      m[k][4 + k] = 1.0;
    }
    for (int k = 0; k < 4; ++k) {
      if (!eliminate(m, k)) refuse(robot, mode, kNames[k]);
    }
    std::vector<double> inverse(rows.size());
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t l = 0; l < 4; ++l) {
        double sum = 0.0;
        for (std::size_t k = 0; k < 4; ++k) sum += (rows[4 * i + k] * scale[k]) * m[k][4 + l];
        inverse[4 * i + l] = sum * scale[l];
      }
    }
    return inverse;
  }

  /// One column of Gauss-Jordan with partial pivoting; false where the pivot vanishes.
  static bool eliminate(double (&m)[4][8], int k) {
    int best = k;
    for (int r = k + 1; r < 4; ++r) {
      if (abs(m[r][k]) > abs(m[best][k])) best = r;
    }
    if (!(abs(m[best][k]) > 1e-9)) return false;
    for (int c = 0; c < 8; ++c) {
      const double swap = m[k][c];
      m[k][c] = m[best][c];
      m[best][c] = swap;
    }
    const double pivot = m[k][k];
    for (int c = 0; c < 8; ++c) m[k][c] /= pivot;
    for (int r = 0; r < 4; ++r) {
      if (r == k) continue;
      const double factor = m[r][k];
      for (int c = 0; c < 8; ++c) m[r][c] -= factor * m[k][c];
    }
    return true;
  }

  [[noreturn]] static void refuse(const std::string& robot, const std::string& mode,
                                  const std::string& what) {
    throw std::runtime_error("the rotors of robot `" + robot + "` cannot give " + what +
                             " independently, which " + mode +
                             " needs: check position, axis, direction and moment_constant in its "
                             "rotors file, or use controller `srt`");
  }

  std::vector<Row> rotors_;
};

}  // namespace skybody::control
