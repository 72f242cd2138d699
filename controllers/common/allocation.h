// Allocation of a collective thrust and a body torque to rotor thrusts, for any robot whose rotors
// are fixed to its base.
//
// f = P u, with u = (F_z, tau) and P the pseudo-inverse (pseudo_inverse.h) of the selected rotors
// (allocated_rotors.h). Sideways forces of tilted rotors are not controlled. If all rotors are
// selected, the three methods give bitwise equal thrusts for a command within the rotors' limits.
// Otherwise they differ in how they satisfy least_i <= f_i <= full_i, where least_i is 0 except for
// reversible rotors:
//
// - priority: reduces yaw torque first, then thrust, then roll and pitch torque (priority.h);
// - pseudo_inverse: clamps each rotor at its own limits, which changes all four values;
// - qp: minimises the weighted error, so the lowest weight gives way first
//   (bounded_least_squares.h); uses all rotors.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "controllers/common/allocated_rotors.h"
#include "controllers/common/bounded_least_squares.h"

namespace skybody::control {

/// Parameters of controllers with allocation.
class AllocationChoice {
 public:
  explicit AllocationChoice(Plugin* owner)
      : form_(owner, choice("allocation", "priority", {"priority", "pseudo_inverse", "qp"},
                            "method at the rotors' limits: reduce yaw, then thrust, then roll and "
                            "pitch; clamp each rotor; or weighted least squares")),
        weights_(owner,
                 reals("allocation_weights", "", {10.0, 100.0, 100.0, 1.0}, between(1e-3, 1e6),
                       "qp: weights of the errors of thrust, roll, pitch, yaw, relative to their "
                       "largest values")) {}

  /// Whether the method differs from the default.
  bool is_chosen() const { return form() != "priority" || weights_.is_given(); }
  const std::string& form() const { return form_.value(); }

  /// @throws std::runtime_error if weights are given to a method without weights, or are too far
  ///     apart for double precision
  std::vector<double> weights() const {
    if (form() != "qp" && weights_.is_given()) {
      refuse("`allocation_weights` are given, but `allocation` is `", form(),
             "`, which has none: set `allocation: qp`, or leave them out");
    }
    double least = weights_.value(0), most = least;
    for (int k = 1; k < weights_.count(); ++k) {
      least = min(least, weights_.value(k));
      most = max(most, weights_.value(k));
    }
    if (most > 1000.0 * least) {
      refuse("`allocation_weights` are from ", least, " to ", most,
             ", a ratio of more than 1000: bring them closer");
    }
    std::vector<double> shares;
    for (int k = 0; k < weights_.count(); ++k) shares.push_back(weights_.value(k) / most);
    return shares;
  }

 private:
  TextParameter form_;
  RealsParameter weights_;
};

/// The allocation of one robot. Immutable after configure().
class Allocation {
 public:
  /// Allocation by the method of `choice`.
  /// @throws std::runtime_error if thrust and torques are not all reachable
  void configure(const Setup& setup, int robot, const std::string& mode,
                 const AllocationChoice& choice) {
    const std::vector<double> weights = choice.weights();
    const bool is_qp = choice.form() == "qp";
    configure(setup, robot, mode, is_qp ? RotorSelection::kAll : RotorSelection::kUseful);
    is_priority_ = choice.form() == "priority";
    if (is_qp) set_least_squares(setup, robot, weights);
  }

  /// Allocation by priority.
  /// @throws std::runtime_error if thrust and torques are not all reachable
  void configure(const Setup& setup, int robot, const std::string& mode,
                 RotorSelection taking = RotorSelection::kUseful) {
    const View<RotorInfo> rotors = working_rotors(setup, robot, mode);
    const BodyInfo& base = setup.bodies()[base_of(setup, robot)];
    const std::string name = robot_name(setup, robot);
    if (rotors.size() < 4) {
      refuse("robot `", name, "` has ", rotors.size(), " rotors; ", mode,
             " needs 4 or more: use controller `srt`");
    }
    require_on_base(setup, robot, rotors,
                    "; " + mode + " needs rotors fixed to the base: use controller `srt`");
    rows_ = effect_rows(rotors, base);
    rotors_ = allocated_rotors(rotors, base, name, mode, taking);
  }

  int rotor_count() const { return static_cast<int>(rotors_.size()); }

  /// Writes rotor thrusts [N], within their limits.
  template <class Real>
  SKYBODY_INLINE void thrusts(const Real& thrust, const Vec3<Real>& torque,
                              Values<Real> output) const {
    const Priority priority(rotors_);
    const Priority::Shares<Real> use = is_priority_
                                           ? priority.fitting(thrust, torque)
                                           : Priority::Shares<Real>{thrust, Real(1.0), Real(1.0)};
    if (least_squares_ != nullptr) {
      nearest(use, torque, output);
      return;
    }
    for (int i = 0; i < rotor_count(); ++i) {
      const AllocatedRotor& r = rotor(i);
      output.set(i, clamp(Priority::push(r, use, torque), Real(r.least), Real(r.full)));
    }
  }

  /// Writes rotor speeds [rad/s] instead of thrusts.
  template <class Real>
  SKYBODY_INLINE void speeds(const Real& thrust, const Vec3<Real>& torque,
                             Values<Real> output) const {
    thrusts(thrust, torque, output);
    for (int i = 0; i < rotor_count(); ++i) {
      output.set(i, speed_for(Real(output[i]), rotor(i).least, rotor(i).per_constant));
    }
  }

  /// Converts the thrusts [N] in `output` to speeds. @returns the torque about z of the thrusts [N
  /// m]
  template <class Real>
  SKYBODY_INLINE Real speeds_and_yaw(Values<Real> output) const {
    Real yaw(0.0);
    for (int i = 0; i < rotor_count(); ++i) {
      const Real push = output[i];
      yaw += push * rows_[4 * static_cast<std::size_t>(i) + 3];
      output.set(i, speed_for(push, rotor(i).least, rotor(i).per_constant));
    }
    return yaw;
  }

 private:
  static constexpr int kMost = BoundedLeastSquares::kMostRotors;

  const AllocatedRotor& rotor(int i) const { return rotors_[static_cast<std::size_t>(i)]; }
  /// Range of a rotor's thrust [N].
  double range(int i) const { return rotor(i).full - rotor(i).least; }

  void set_least_squares(const Setup& setup, int robot, const std::vector<double>& weights) {
    const int n = rotor_count();
    if (n > kMost) {
      refuse("robot `", robot_name(setup, robot), "` has ", n, " rotors; `allocation: qp` takes ",
             kMost, " at most: use `priority`");
    }
    const ThrustTorqueLimits limits =
        limits_of(setup.rotors_of(robot), setup.bodies()[base_of(setup, robot)]);
    const double scale[4] = {limits.thrust, limits.torque.x, limits.torque.y, limits.torque.z};
    std::vector<double> weighted;
    for (std::size_t k = 0; k < 4; ++k) {
      for (int i = 0; i < n; ++i) {
        weighted.push_back(weights[k] * rows_[4 * static_cast<std::size_t>(i) + k] *
                           (rotor(i).full - rotor(i).least) / scale[k]);
      }
    }
    least_squares_ = std::make_unique<BoundedLeastSquares>();
    least_squares_->configure(n, weighted.data());
  }

  /// Uses the thrusts of the pseudo-inverse in lanes where they are within limits. Solves the least
  /// squares in the other lanes, one at a time.
  template <class Real>
  SKYBODY_INLINE void nearest(const Priority::Shares<Real>& use, const Vec3<Real>& torque,
                              Values<Real> output) const {
    MaskOf<Real> within(true), is_usable(true);
    for (int i = 0; i < rotor_count(); ++i) {
      const Real push = Priority::push(rotor(i), use, torque);
      within = logical_and(within, logical_and(push >= rotor(i).least, push <= rotor(i).full));
      is_usable = logical_and(is_usable, abs(push) < kLargest);
      output.set(i, push);
    }
    const auto beyond = logical_and(is_usable, logical_not(within));
    if (none(beyond)) return;
    Real best[kMost];
    for (int i = 0; i < rotor_count(); ++i) {
      best[i] = Priority::push(rotor(i), use, torque);
    }
    for (int l = 0; l < kLanesOf<Real>; ++l) {
      if (((bits_from_mask(beyond) >> l) & 1u) != 0) solve_lane(best, l);
    }
    for (int i = 0; i < rotor_count(); ++i) output.set(i, best[i]);
  }

  /// Replaces lane l of the thrusts with the least-squares solution.
  template <class Real>
  SKYBODY_INLINE void solve_lane(Real (&push)[kMost], int l) const {
    double setpoint[kMost], share[kMost];
    BoundedLeastSquares::Place at[kMost];
    for (int i = 0; i < rotor_count(); ++i) {
      setpoint[i] = (lane(value_of(push[i]), l) - rotor(i).least) / range(i);
    }
    least_squares_->solve(setpoint, share, at);
    if constexpr (kIsDual<Real>) {
      double turn[kMost], slope[kMost];
      for (int i = 0; i < rotor_count(); ++i) turn[i] = lane(push[i].tangent, l) / range(i);
      least_squares_->move(turn, at, slope);
      for (int i = 0; i < rotor_count(); ++i) {
        set_lane(push[i].value, l, rotor(i).least + share[i] * range(i));
        set_lane(push[i].tangent, l, slope[i] * range(i));
      }
    } else {
      for (int i = 0; i < rotor_count(); ++i) {
        set_lane(push[i], l, rotor(i).least + share[i] * range(i));
      }
    }
  }

  template <class R>
  static SKYBODY_INLINE const R& value_of(const Dual<R>& x) {
    return x.value;
  }
  template <class R>
  static SKYBODY_INLINE const R& value_of(const R& x) {
    return x;
  }

  std::vector<AllocatedRotor> rotors_;
  std::vector<double> rows_;  ///< N x 4: thrust and torque [m] per thrust of each rotor
  bool is_priority_ = true;
  std::unique_ptr<BoundedLeastSquares> least_squares_;  ///< solver of `qp`
};

}  // namespace skybody::control
