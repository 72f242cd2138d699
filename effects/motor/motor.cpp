// Motor: direct-current motors with a current-limited speed controller, in place of the first-order
// lag of paper eq. 2.
//
// Three torques act on a motor: k i of the current, air drag k_m w^2, friction. The equation is
// stiff at low resistance, and the engine needs one acceleration for the whole step. So the
// equation is linearised about the speed at the start of the step, and the acceleration is the one
// that reaches the exact end of the linear equation: an exponential, stable for every dt. Each
// current limit has its own linear equation; the most restrictive one applies.
#include <vector>

#include "effects/common/rotors.h"

namespace skybody {
namespace {

class Motor : public Effect {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    dt_ = setup.dt();
    for (const int robot : effect::robots_with_one_way_rotors(setup, robots_.values(), "`motor`")) {
      const double speed = effect::hover_speed(setup, robot);
      for (const RotorInfo& rotor : setup.rotors_of(robot)) {
        check_rotor(rotor, speed);
        rotors_.push_back({static_cast<int>(&rotor - setup.rotors().begin()), rotor.first_param});
      }
    }
    setup.holds(HeldInput::kRotorRate);
  }

  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>&, Held<Real>& held) const {
    const Constants<Real> motor = constants(env);
    for (const Rotor& rotor : rotors_) {
      const Load<Real> load = load_of(env, rotor);
      const Real speed = env.rotor_speed(rotor.index);
      const Real command = max(env.rotor_command(rotor.index), 0.0);
      const Real end = speed_after(motor, load, speed, voltage(motor, load, command));
      held.set_acceleration(rotor.index, (end - speed) * (1.0 / dt_));
    }
  }

 private:
  struct Rotor {
    int index;        ///< world index
    int first_param;  ///< first of its constants
  };
  /// Constants of the motors, per environment.
  template <class Real>
  struct Constants {
    Real torque;            ///< k: torque per current [N m/A], and back EMF per speed [V s/rad]
    Real per_ohm;           ///< 1 / R
    Real friction;          ///< [N m]
    Real driving, braking;  ///< torques at the current limits [N m]
    Real voltage;           ///< largest voltage [V]
  };
  /// Load of a motor.
  template <class Real>
  struct Load {
    Real per_inertia;  ///< 1 / J
    Real drag;         ///< k_m
  };

  template <class Real>
  SKYBODY_INLINE Constants<Real> constants(const EnvView<Real>& env) const {
    const Real torque = torque_constant_(env), most = torque * max_current_(env);
    return {torque,
            1.0 / resistance_(env),
            friction_(env),
            most,
            brake_.value() ? Real(-most) : Real(0.0),
            voltage_(env)};
  }

  template <class Real>
  SKYBODY_INLINE Load<Real> load_of(const EnvView<Real>& env, const Rotor& rotor) const {
    // A randomized inertia may be 0; a motor of this inertia already follows at once.
    const Real inertia = max(env.param(rotor.first_param + SKYBODY_ROTOR_INERTIA), 1e-12);
    return {1.0 / inertia, env.param(rotor.first_param + SKYBODY_ROTOR_MOMENT_CONSTANT)};
  }

  /// The steady-state voltage of the commanded speed, V = k w + (R / k) (k_m w^2 + friction),
  /// limited by the supply.
  template <class Real>
  SKYBODY_INLINE Real voltage(const Constants<Real>& motor, const Load<Real>& load,
                              const Real& command) const {
    const Real torque = load.drag * (command * command) + motor.friction;
    return min(motor.torque * command + torque / (motor.torque * motor.per_ohm), motor.voltage);
  }

  /// Speed at the end of the step at that voltage [rad/s].
  template <class Real>
  SKYBODY_INLINE Real speed_after(const Constants<Real>& motor, const Load<Real>& load,
                                  const Real& speed, const Real& volts) const {
    const Real by_speed = motor.torque * motor.torque * motor.per_ohm;
    const Real free = motor.torque * motor.per_ohm * volts - by_speed * speed;
    const Real resisting = load.drag * (speed * speed) + motor.friction;
    const Real slope = -2.0 * load.drag * speed;
    const auto after = [&](const Real& torque, const Real& torque_slope) {
      return speed + change((torque - resisting) * load.per_inertia,
                            (torque_slope + slope) * load.per_inertia);
    };
    // The solution of dw/dt = min(f, g) is below those of f and of g; with max it is above them.
    const Real unlimited = after(free, Real(-by_speed));
    const Real slowest = after(motor.braking, Real(0.0));
    const Real fastest = after(motor.driving, Real(0.0));
    return clamp(unlimited, slowest, fastest);
  }

  /// Change over the step for an initial rate and a slope <= 0: the integral of rate exp(slope t).
  template <class Real>
  SKYBODY_INLINE Real change(const Real& rate, const Real& slope) const {
    const Real steep = slope * dt_;
    const auto is_straight = steep > -1e-12;
    const Real safe = select(is_straight, Real(-1.0), steep);
    return rate * (dt_ * select(is_straight, Real(1.0), expm1(safe) / safe));
  }

  void check_rotor(const RotorInfo& rotor, double hover) const {
    const std::string name = "rotor `" + std::string(rotor.name) + "`";
    if (!(rotor.constants[SKYBODY_ROTOR_INERTIA] > 0.0)) {
      refuse(name,
             " has an `inertia` of 0, which a motor would speed up in no time: give it one above 0 "
             "in the robot's rotors file");
    }
    const double needed =
        rotor.constants[SKYBODY_ROTOR_MOMENT_CONSTANT] * hover * hover + friction_.value();
    const double most = torque_constant_.value() * max_current_.value();
    if (most <= needed) {
      refuse("a motor gives ", most, " N m at `max_current`, and ", name, " takes ", needed,
             " N m to hover: raise `max_current` or `torque_constant`");
    }
    const double volts =
        torque_constant_.value() * hover + resistance_.value() / torque_constant_.value() * needed;
    if (voltage_.value() <= volts) {
      refuse("`voltage` is ", voltage_.value(), " V, and ", name, " takes ", volts,
             " V to hover: raise it, or lower `torque_constant` or `resistance`");
    }
  }

  TextsParameter robots_{this, words("robots", "robots with these motors; empty: all with rotors")};
  RealParameter torque_constant_{
      this, randomizable(required(
                real("torque_constant", "N m/A", 0.0, between(1e-6, 1000.0),
                     "torque constant k; the back EMF per speed in V s/rad has the same value")))};
  RealParameter resistance_{
      this, randomizable(required(real("resistance", "ohm", 0.0, between(1e-6, 1e6),
                                       "resistance R of the winding and its controller")))};
  RealParameter max_current_{
      this, randomizable(required(real("max_current", "A", 0.0, between(1e-6, 1e6),
                                       "current limit of the controller, forward and braking")))};
  RealParameter voltage_{
      this, randomizable(required(real("voltage", "V", 0.0, between(1e-3, 1e6),
                                       "voltage of the supply, the largest at the motor")))};
  RealParameter friction_{
      this, randomizable(real("friction", "N m", 0.0, between(0.0, 1000.0),
                              "torque of bearings and iron losses, against the rotation"))};
  BooleanParameter brake_{
      this, boolean("brake", true, "the current may be negative and brake the motor")};

  double dt_ = 0.0;
  std::vector<Rotor> rotors_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Motor, "motor", "1.0.0",
               "Direct-current motors with current and voltage limits [A, V].");
