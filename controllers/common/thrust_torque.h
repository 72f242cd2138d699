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

/// Settings of the actuation.
struct ThrustTorqueChoice {
  bool rotors = true;       ///< false: wrench on the body
  bool lag = true;          ///< body only: lag of eq. 2, or immediate
  double time_up = -1.0;    ///< [s]; negative: mean tau_up of the environment's rotors
  double time_down = -1.0;  ///< [s]; negative: mean tau_down of the environment's rotors
  double max_thrust = 0.0;  ///< [N]; 0: the rotors' limit
  Vec3<double> max_torque{0.0, 0.0, 0.0};  ///< [N m]; 0: the rotors' limit
};

class ThrustTorque {
 public:
  /// Declares output and site. @throws std::runtime_error
  void configure(const Setup& setup, int robot, const std::string& mode,
                 const ThrustTorqueChoice& choice, const AllocationChoice& allocation) {
    choice_ = choice;
    dt_ = setup.dt();
    const BodyInfo& base = setup.bodies()[base_of(setup, robot)];
    for (const RotorInfo& rotor : setup.rotors_of(robot)) {
      effects_.push_back(effect_of(rotor, base));
      constants_.push_back(rotor.first_param);
    }
    first_rotor_ = setup.robots()[robot].first_rotor;
    set_limits(setup, robot, mode, base);
    keep_up_ = keep(choice.time_up);
    keep_down_ = keep(choice.time_down);
    if (choice.rotors) {
      allocation_.configure(setup, robot, mode, allocation);
      setup.output(Signal::kRotorSpeed, allocation_.rotor_count());
    } else {
      if (allocation.is_chosen()) {
        throw std::runtime_error(
            "`allocation` is given, but `apply` is `body`, past the rotors: set `apply: rotors`, "
            "or "
            "leave it out");
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
    if (choice_.rotors) {
      allocation_.speeds(t, torque, output);
      return;
    }
    const Vec3<Real> limited = clamp_symmetric(torque, limits_.torque);
    const Real up =
        choice_.lag ? lane_keep(env, choice_.time_up, keep_up_, SKYBODY_ROTOR_TAU_UP) : Real(0.0);
    const Real down = choice_.lag
                          ? lane_keep(env, choice_.time_down, keep_down_, SKYBODY_ROTOR_TAU_DOWN)
                          : Real(0.0);
    state.thrust = approach(state.thrust, t, up, down);
    state.torque = {approach(state.torque.x, limited.x, up, down),
                    approach(state.torque.y, limited.y, up, down),
                    approach(state.torque.z, limited.z, up, down)};
    output.set(0, Vec3<Real>{Real(0.0), Real(0.0), state.thrust});
    output.set(3, state.torque);
  }

 private:
  void set_limits(const Setup& setup, int robot, const std::string& mode, const BodyInfo& base) {
    const bool given = choice_.max_thrust > 0.0 && choice_.max_torque.x > 0.0 &&
                       choice_.max_torque.y > 0.0 && choice_.max_torque.z > 0.0;
    if (effects_.empty() && !choice_.rotors && given) {
      limits_ = {choice_.max_thrust, choice_.max_torque};
      return;
    }
    if (effects_.empty() && !choice_.rotors) {
      throw std::runtime_error("robot `" + robot_name(setup, robot) +
                               "` has no rotors to take limits "
                               "from: give " +
                               mode + " `max_thrust` and `max_torque`, all above 0");
    }
    limits_ = limits_of(working_rotors(setup, robot, mode), base);
    limits_.thrust = tighter("max_thrust", choice_.max_thrust, limits_.thrust);
    limits_.torque = {tighter("max_torque[0]", choice_.max_torque.x, limits_.torque.x),
                      tighter("max_torque[1]", choice_.max_torque.y, limits_.torque.y),
                      tighter("max_torque[2]", choice_.max_torque.z, limits_.torque.z)};
    if (!(limits_.thrust > 0.0)) {
      throw std::runtime_error("no rotor of robot `" + robot_name(setup, robot) +
                               "` pushes along +z of its base: check `axis` in its rotors file");
    }
  }

  static double tighter(const std::string& name, double given, double possible) {
    if (given > possible * (1.0 + 1e-9)) {
      throw std::runtime_error("`" + name + "` " + to_text(given) +
                               " is more than the rotors can do, " + to_text(possible) +
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

  ThrustTorqueChoice choice_;
  ThrustTorqueLimits limits_;
  Allocation allocation_;
  std::vector<RotorEffect> effects_;
  std::vector<int> constants_;  ///< first EnvParam of each rotor
  int first_rotor_ = 0;
  double dt_ = 0.0;
  double keep_up_ = 0.0, keep_down_ = 0.0;
};

}  // namespace skybody::control
