// Actuation of a collective thrust and a body torque: through the rotors, or as a wrench at the
// base's centre of mass behind a first-order lag (paper eq. 1 and 2). Shared by ctbt and ctbr.
#pragma once

#include <string>
#include <vector>

#include "controllers/common/allocation.h"

namespace skybody::control {

/// The present thrust [N] and torque [N m, base axes] at the centre of mass, behind the lag: u of
/// eq. 2.
template <class Real>
struct ThrustTorqueState {
  Real thrust;
  Vec3<Real> torque;
};

/// The actuation and its parameters. Declared as a member of the controller `owner`.
class ThrustTorque {
 public:
  explicit ThrustTorque(Plugin* owner)
      : apply_(owner, choice("apply", "rotors", {"rotors", "body"},
                             "rotors: by allocation; body: lagged wrench on the body (eq. 1 and "
                             "2)")),
        time_up_(owner, real("time_constant_up", "s", -1.0, at_least(-1.0),
                             "body: time constant of the lag while a channel grows; below 0: the "
                             "rotors' mean")),
        time_down_(owner, real("time_constant_down", "s", -1.0, at_least(-1.0),
                               "body: time constant of the lag while a channel shrinks; below 0: "
                               "the rotors' mean")),
        max_thrust_(owner, real("max_thrust", "N", 0.0, at_least(0.0),
                                "thrust for action +1; 0: all rotors' full thrust")),
        choice_(owner) {}

  bool is_by_rotors() const { return apply_.value() == "rotors"; }

  /// Declares output and site. @throws std::runtime_error
  /// @param has_lag     of the wrench on the body; false: immediate
  /// @param max_torque  [N m]; 0: the rotors' limit
  void configure(const Setup& setup, int robot, const std::string& mode, bool has_lag,
                 const Vec3<double>& max_torque) {
    by_rotors_ = is_by_rotors();
    has_lag_ = has_lag;
    dt_ = setup.dt();
    const BodyInfo& base = setup.bodies()[base_of(setup, robot)];
    for (const RotorInfo& rotor : setup.rotors_of(robot)) {
      effects_.push_back(effect_of(rotor, base));
      constants_.push_back(rotor.first_param);
    }
    first_rotor_ = setup.robots()[robot].first_rotor;
    set_limits(setup, robot, mode, base, max_torque);
    keep_up_ = keep(time_up_.value());
    keep_down_ = keep(time_down_.value());
    if (by_rotors_) {
      allocation_.configure(setup, robot, mode, choice_);
      setup.output(Signal::kRotorSpeed, allocation_.rotor_count());
    } else {
      if (choice_.is_chosen()) {
        refuse(
            "`allocation` is given, but `apply` is `body`, past the rotors: set `apply: rotors`, "
            "or leave it out");
      }
      setup.site({base_of(setup, robot), {0.0, 0.0, 0.0}, 1, 0});
      setup.output(Signal::kWrench, 6);
    }
  }

  const ThrustTorqueLimits& limits() const { return limits_; }

  /// Initialises the lag from the rotors' speeds at the reset, so that an episode can start in
  /// hover.
  template <class Real>
  SKYBODY_INLINE void reset(const EnvView<Real>& env, ThrustTorqueState<Real>& state) const {
    Real thrust(0.0);
    Vec3<Real> torque{Real(0.0), Real(0.0), Real(0.0)};
    for (std::size_t i = 0; i < effects_.size(); ++i) {
      const Real speed = env.rotor_speed(first_rotor_ + static_cast<int>(i));
      const Real push =
          env.param(constants_[i] + SKYBODY_ROTOR_THRUST_CONSTANT) * (speed * abs(speed));
      thrust += effects_[i].thrust * push;
      torque += lift<Real>(effects_[i].torque) * push;
    }
    state.thrust = thrust;
    state.torque = torque;
  }

  template <class Real>
  SKYBODY_INLINE void drive(const EnvView<Real>& env, ThrustTorqueState<Real>& state,
                            const Real& thrust, const Vec3<Real>& torque,
                            Values<Real> output) const {
    const Real t = clamp(thrust, Real(0.0), Real(limits_.thrust));
    if (by_rotors_) {
      allocation_.speeds(t, torque, output);
      return;
    }
    const Vec3<Real> limited = clamp_symmetric(torque, limits_.torque);
    const Real up =
        has_lag_ ? lane_keep(env, time_up_.value(), keep_up_, SKYBODY_ROTOR_TAU_UP) : Real(0.0);
    const Real down = has_lag_
                          ? lane_keep(env, time_down_.value(), keep_down_, SKYBODY_ROTOR_TAU_DOWN)
                          : Real(0.0);
    state.thrust = approach(state.thrust, t, up, down);
    state.torque = {approach(state.torque.x, limited.x, up, down),
                    approach(state.torque.y, limited.y, up, down),
                    approach(state.torque.z, limited.z, up, down)};
    output.set(0, Vec3<Real>{Real(0.0), Real(0.0), state.thrust});
    output.set(3, state.torque);
  }

 private:
  void set_limits(const Setup& setup, int robot, const std::string& mode, const BodyInfo& base,
                  const Vec3<double>& max_torque) {
    const double max_thrust = max_thrust_.value();
    if (effects_.empty() && !by_rotors_ && max_thrust > 0.0 && all_above_zero(max_torque)) {
      limits_ = {max_thrust, max_torque};
      return;
    }
    if (effects_.empty() && !by_rotors_) {
      refuse("robot `", robot_name(setup, robot), "` has no rotors to take limits from: give ",
             mode, " `max_thrust` and `max_torque`, all above 0");
    }
    limits_ = limits_of(working_rotors(setup, robot, mode), base);
    limits_.thrust = tighter("max_thrust", max_thrust, limits_.thrust);
    limits_.torque = {tighter("max_torque[0]", max_torque.x, limits_.torque.x),
                      tighter("max_torque[1]", max_torque.y, limits_.torque.y),
                      tighter("max_torque[2]", max_torque.z, limits_.torque.z)};
    if (!(limits_.thrust > 0.0)) {
      refuse("no rotor of robot `", robot_name(setup, robot),
             "` pushes along +z of its base: check `axis` in its rotors file");
    }
  }

  static double tighter(const std::string& name, double given, double possible) {
    if (given > possible * (1.0 + 1e-9)) {
      refuse("`", name, "` ", given, " is more than the rotors can do, ", possible,
             ": lower it, or leave it out for that limit");
    }
    return given > 0.0 ? given : possible;
  }

  /// exp(-dt / time constant); 0 for a time constant of 0.
  double keep(double time) const { return time > 0.0 ? exp(-dt_ / time) : 0.0; }

  template <class Real>
  SKYBODY_INLINE Real lane_keep(const EnvView<Real>& env, double time, double constant,
                                int which) const {
    if (time >= 0.0 || constants_.empty()) return Real(constant);
    Real sum(0.0);
    for (const int first : constants_) sum += env.param(first + which);
    const Real mean = sum / static_cast<double>(constants_.size());
    const auto slow = mean > 1e-9;
    return select(slow, exp(-dt_ / select(slow, mean, Real(1.0))), Real(0.0));
  }

  /// Eq. 2 for one channel. A growing magnitude is "rising", so that both signs behave alike.
  template <class Real>
  static SKYBODY_INLINE Real approach(const Real& u, const Real& reference, const Real& keep_up,
                                      const Real& keep_down) {
    const Real keep = select(abs(reference) > abs(u), keep_up, keep_down);
    return u * keep + reference * (1.0 - keep);
  }

  TextParameter apply_;
  RealParameter time_up_, time_down_, max_thrust_;
  AllocationChoice choice_;
  bool by_rotors_ = true, has_lag_ = true;
  ThrustTorqueLimits limits_;
  Allocation allocation_;
  std::vector<RotorEffect> effects_;
  std::vector<int> constants_;  ///< first EnvParam of each rotor
  int first_rotor_ = 0;
  double dt_ = 0.0;
  double keep_up_ = 0.0, keep_down_ = 0.0;
};

}  // namespace skybody::control
