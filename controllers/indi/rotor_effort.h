// Force and torque of the rotors since the last call, from their measured speeds.
//
// For a rotor whose speed changed linearly from a to b:
//   thrust  k_f (a^2 + a b + b^2) / 3 along its axis, the mean of k_f w^2; for reversible rotors
//           k_f (a |a| + 4 m |m| + b |b|) / 6, m = (a + b) / 2, the mean of k_f w |w|
//   torque  the thrust's arm and reaction (allocation.h), and -d J (b - a) / T about its axis
// with d its direction of rotation, J its inertia and T the time between the calls. The first two
// are the effectiveness G1 of E. Smeur, Q. Chu, G. de Croon, Adaptive incremental nonlinear dynamic
// inversion for attitude control of micro air vehicles, JGCD 39(3), 2016, the last one is G2.
#pragma once

#include <vector>

#include "controllers/common/allocation.h"

namespace skybody {

/// Effect of all rotors on the base, B axes.
template <class Real>
struct RotorEffort {
  Vec3<Real> force;   ///< mean [N]
  Vec3<Real> torque;  ///< about the base's centre of mass, mean [N m]
};

class RotorEfforts {
 public:
  /// @param interval  time between two calls [s]
  void configure(const Setup& setup, int robot, double interval) {
    const BodyInfo& base = setup.bodies()[control::base_of(setup, robot)];
    first_ = setup.robots()[robot].first_rotor;
    for (const RotorInfo& rotor : setup.rotors_of(robot)) {
      const double* c = rotor.constants;
      const double thrust = c[SKYBODY_ROTOR_THRUST_CONSTANT] / 3.0;
      const Vec3<double> axis = control::vec3(rotor.axis_in_base);
      const Vec3<double> spin = axis * (-rotor.direction * c[SKYBODY_ROTOR_INERTIA] / interval);
      rows_.push_back({axis * thrust, control::effect_of(rotor, base).torque * thrust, spin});
      is_level_ = is_level_ && axis.x == 0.0 && axis.y == 0.0;
      spins_ = spins_ || c[SKYBODY_ROTOR_INERTIA] > 0.0;
      is_reversible_ = is_reversible_ || control::is_reversible(rotor);
    }
  }

  int count() const { return static_cast<int>(rows_.size()); }
  /// Whether all axes, and so the force, are along z of the base.
  bool is_level() const { return is_level_; }

  /// @param last  speeds at the last call [rad/s], from value 0 on; updated to the present speeds
  template <class Real>
  SKYBODY_INLINE RotorEffort<Real> since(const EnvView<Real>& env, Values<Real> last) const {
    const Real zero(0.0);
    RotorEffort<Real> sum{{zero, zero, zero}, {zero, zero, zero}};
    for (int i = 0; i < count(); ++i) {
      const Row& r = rows_[static_cast<std::size_t>(i)];
      const Real b = env.rotor_speed(first_ + i), a = last[i];
      const Real square = is_reversible_ ? signed_square(a, b) : a * a + b * (a + b);
      last.set(i, b);
      if (is_level_) {
        sum.force.z += square * r.force.z;
      } else {
        sum.force += control::lift<Real>(r.force) * square;
      }
      sum.torque += control::lift<Real>(r.torque) * square;
      if (!spins_) continue;
      if (is_level_) {
        sum.torque.z += (b - a) * r.spin.z;
      } else {
        sum.torque += control::lift<Real>(r.spin) * (b - a);
      }
    }
    return sum;
  }

  /// Stores the present speeds as those of the last call.
  template <class Real>
  SKYBODY_INLINE void start(const EnvView<Real>& env, Values<Real> last) const {
    for (int i = 0; i < count(); ++i) last.set(i, env.rotor_speed(first_ + i));
  }

 private:
  /// Three times the mean of w |w|.
  template <class Real>
  static SKYBODY_INLINE Real signed_square(const Real& a, const Real& b) {
    const Real sum = a + b;
    return 0.5 * (a * abs(a) + sum * abs(sum) + b * abs(b));
  }

  struct Row {
    Vec3<double> force, torque;  ///< per three times the mean square of the speed
    Vec3<double> spin;           ///< torque per change of speed
  };
  std::vector<Row> rows_;
  int first_ = 0;
  bool is_level_ = true, spins_ = false, is_reversible_ = false;
};

}  // namespace skybody
