// Incremental nonlinear dynamic inversion: follows a trajectory, an attitude or body rates, and
// compensates disturbances from measured accelerations. Equations: README.md.
#include <string>
#include <vector>

#include "controllers/common/attitude_error.h"
#include "controllers/common/flatness.h"
#include "controllers/common/guidance.h"
#include "controllers/common/low_pass.h"
#include "controllers/common/measured_motion.h"
#include "controllers/common/trajectory.h"
#include "controllers/indi/rotor_effort.h"

namespace skybody {
namespace {

/// Default gain of the rate loop, the fastest loop [rad/s].
constexpr double kRateGain = 24.0;
/// Default interval between two evaluations [s].
constexpr double kDefaultInterval = 0.002;

class Indi : public Controller {
 public:
  static constexpr bool kSmooth = true;

  template <class Real>
  struct State {
    Vec3<Real> rate;                           ///< at the last call, B axes [rad/s]
    control::LowPassState<Vec3<Real>> moment;  ///< filter of the disturbance torque [N m]
    Real reaction;                             ///< torque commanded from the rotors' drag about z
                                               ///< [N m]
  };

  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    level_ = level_of(signal_.value());
    error_.configure();
    base_ = control::base_of(setup, robot);
    mass_ = control::total_mass(setup, robot);
    inertia_ = control::inertia_of(setup.bodies()[base_]);
    set_interval(setup);
    allocation_.configure(setup, robot, "indi", allocation_choice_);
    set_rotors(setup, robot);
    filter_.configure("cutoff", cutoff_.value(), interval_);
    set_gains(setup, robot);
    measured_.configure(setup);
    declare(setup);
  }

  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state, Values<Real> buffer) const {
    const BodyMotion<Real> base = env.body(base_);
    state.rate = base.angular_velocity;
    rotors_.start(env, buffer);
    if (level_ == Level::kTrajectory) buffer.set(velocity_place(), base.velocity);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>& state, ConstValues<Real> input,
               Values<Real> output, Values<Real> buffer) const {
    BodyMotion<Real> base = env.body(base_);
    base.angular_velocity = measured_.rates(env, base.angular_velocity);
    const RotorEffort<Real> effort = rotors_.since(env, buffer);
    const Vec3<Real> gyroscopic =
        cross(base.angular_velocity, control::lift<Real>(inertia_) * base.angular_velocity);
    const Vec3<Real> moment = other_moment(env, state, base, effort, gyroscopic);
    Real thrust;
    const Vec3<Real> setpoint = desired(env, base, effort, input, buffer, thrust);
    drive(state, thrust, (control::lift<Real>(inertia_) * setpoint + gyroscopic) - moment, output);
  }

 private:
  enum class Level { kTrajectory, kAttitude, kRates };

  static Level level_of(const std::string& word) {
    if (word == "trajectory") return Level::kTrajectory;
    return word == "attitude" ? Level::kAttitude : Level::kRates;
  }

  void set_interval(const Setup& setup) {
    const std::int64_t fits = static_cast<std::int64_t>(kDefaultInterval / setup.dt() + 1e-9);
    const std::int64_t steps = period_.value() > 0 ? period_.value() : (fits > 1 ? fits : 1);
    interval_ = static_cast<double>(steps) * setup.dt();
    per_interval_ = 1.0 / interval_;
    setup.period(static_cast<int>(steps));
  }

  /// Torque about z from the rotors' reactions, and its rate of response.
  void set_rotors(const Setup& setup, int robot) {
    const BodyInfo& base = setup.bodies()[base_];
    const View<RotorInfo> rotors = control::working_rotors(setup, robot, "indi");
    rotors_.configure(setup, robot, interval_);
    limits_ = control::limits_of(rotors, base);
    const double push = mass_ * control::gravity_of(setup) / rotors.size();
    double inertia = 0.0, slope = 0.0;
    for (const RotorInfo& rotor : rotors) {
      const double* c = rotor.constants;
      inertia += c[SKYBODY_ROTOR_INERTIA];
      slope +=
          2.0 * c[SKYBODY_ROTOR_MOMENT_CONSTANT] * sqrt(push / c[SKYBODY_ROTOR_THRUST_CONSTANT]);
    }
    reaction_share_ = interval_ * slope / (inertia + interval_ * slope);
  }

  void set_gains(const Setup& setup, int robot) {
    const double share = control::lag_share(setup, robot, kRateGain);
    rate_share_ = rate_gain_.is_given() ? 1.0 : share;
    attitude_share_ = attitude_gain_.is_given() ? 1.0 : share;
    kp_share_ = kp_.is_given() ? 1.0 : share * share;
    kd_share_ = kd_.is_given() ? 1.0 : share;
    if (level_ == Level::kTrajectory) {
      acceleration_.configure(setup);
    }
  }

  void declare(const Setup& setup) {
    const Vec3<double> rate = max_rate_.vec3();
    int words = rotors_.count();
    std::vector<double> low = {0.0}, high = {limits_.thrust};
    if (level_ == Level::kAttitude) {
      low.insert(low.end(), 4, -1.0);
      high.insert(high.end(), 4, 1.0);
    }
    if (level_ == Level::kRates || feed_forward_.value()) {
      low.insert(low.end(), {-rate.x, -rate.y, -rate.z});
      high.insert(high.end(), {rate.x, rate.y, rate.z});
    }
    if (level_ == Level::kTrajectory) {
      trajectory_.configure(setup);
      words += kLinearWords;
      report_.configure(setup, words++);
    } else {
      setup.input(level_ == Level::kAttitude ? Signal::kAttitude : Signal::kCtbr, low, high);
    }
    setup.buffer(words);
    setup.output(Signal::kRotorSpeed, rotors_.count());
  }

  /// Disturbance torque: the torque not explained by the rotors or the body's spin, from the change
  /// of rates since the last call; filtered. B axes [N m].
  template <class Real>
  SKYBODY_INLINE Vec3<Real> other_moment(const EnvView<Real>& env, State<Real>& state,
                                         const BodyMotion<Real>& base,
                                         const RotorEffort<Real>& effort,
                                         const Vec3<Real>& gyroscopic) const {
    const Vec3<Real> acceleration = (base.angular_velocity - state.rate) * Real(per_interval_);
    state.rate = base.angular_velocity;
    const Vec3<Real> moment =
        (control::lift<Real>(inertia_) * acceleration + gyroscopic) - effort.torque;
    return filter_.filtered(moment * begun(env), state.moment);
  }

  /// Disturbance force per mass: not explained by the rotors or gravity, since the last call;
  /// filtered. W axes [m/s^2].
  template <class Real>
  SKYBODY_INLINE Vec3<Real> other_force(const EnvView<Real>& env, const BodyMotion<Real>& base,
                                        const Vec3<Real>& z, const RotorEffort<Real>& effort,
                                        Values<Real> buffer) const {
    const Vec3<Real> rotors =
        rotors_.is_level() ? z * effort.force.z : rotate(base.rotation, effort.force);
    Vec3<Real> force;
    if (measured_.is_by_imu()) {
      force = rotate(base.rotation, measured_.specific_force(env));
    } else {
      const int place = velocity_place();
      force = (base.velocity - buffer.vec3(place)) * Real(per_interval_);
      force.z += acceleration_.gravity();
      buffer.set(place, base.velocity);
    }
    const int place = velocity_place() + 3;
    control::LowPassState<Vec3<Real>> past{buffer.vec3(place), buffer.vec3(place + 3)};
    const Vec3<Real> filtered =
        filter_.filtered((force - rotors * Real(1.0 / mass_)) * begun(env), past);
    buffer.set(place, past.first);
    buffer.set(place + 3, past.second);
    return filtered;
  }

  /// 0 before an episode's first physics step, when there is no measurement yet, then 1. A factor
  /// instead of a selection: g++ 12 splits selections into single words (docs/stepping.md).
  template <class Real>
  static SKYBODY_INLINE Real begun(const EnvView<Real>& env) {
    return min(Real(to_real(env.physics_step())), Real(1.0));
  }

  /// Angular acceleration for the command, B axes [rad/s^2].
  /// @param[out] thrust  along z of B [N]
  template <class Real>
  SKYBODY_INLINE Vec3<Real> desired(const EnvView<Real>& env, const BodyMotion<Real>& base,
                                    const RotorEffort<Real>& effort, ConstValues<Real> input,
                                    Values<Real> buffer, Real& thrust) const {
    if (level_ == Level::kTrajectory) return followed(env, base, effort, input, buffer, thrust);
    thrust = input[0];
    Vec3<Real> rate;
    if (level_ == Level::kRates) {
      rate = control::clamp_symmetric(input.vec3(1), max_rate_.vec3());
    } else {
      const Quat<Real> left = conjugate(base.rotation) * control::unit_or_identity(input.quat(1));
      rate = turn_rate(env, left);
      if (feed_forward_.value()) rate += rotate(left, input.vec3(5));
    }
    return multiply_elements(rate_gain_.vec3(env) * Real(rate_share_),
                             rate - base.angular_velocity);
  }

  template <class Real>
  SKYBODY_INLINE Vec3<Real> followed(const EnvView<Real>& env, const BodyMotion<Real>& base,
                                     const RotorEffort<Real>& effort, ConstValues<Real> input,
                                     Values<Real> buffer, Real& thrust) const {
    const ReferencePoint<Real> reference = reference_point(input);
    const Vec3<Real> z = body_z(base.rotation);
    const double most = max_error_.value();
    const Vec3<Real> error =
        control::clamp_symmetric(reference.position - base.position, {most, most, most});
    const Vec3<Real> feedback =
        multiply_elements(kp_.vec3(env) * Real(kp_share_), error) +
        multiply_elements(kd_.vec3(env) * Real(kd_share_), reference.velocity - base.velocity);
    const Vec3<Real> setpoint =
        (feedback + reference.acceleration) - other_force(env, base, z, effort, buffer);
    const Vec3<Real> held = acceleration_.held(setpoint), push = acceleration_.thrust_for(held);
    report_.note(control::differs(held, setpoint), buffer);
    thrust = mass_ * dot(push, z);
    const auto flat = control::flat_attitude(push, reference.yaw);
    const auto rates = control::flat_rates(flat, reference.jerk, reference.yaw_rate);
    const Quat<Real> left = conjugate(base.rotation) * flat.rotation;  // B from desired B
    const Vec3<Real> gain = rate_gain_.vec3(env) * Real(rate_share_);
    const Vec3<Real> forward =
        multiply_elements(gain, rates.value) +
        control::flat_acceleration(flat, rates, reference.jerk, reference.snap, reference.yaw_rate);
    return rotate(left, forward) +
           multiply_elements(gain, turn_rate(env, left) - base.angular_velocity);
  }

  /// Rate that removes the remaining rotation, B axes [rad/s].
  template <class Real>
  SKYBODY_INLINE Vec3<Real> turn_rate(const EnvView<Real>& env, const Quat<Real>& left) const {
    const Vec3<Real> rate =
        multiply_elements(attitude_gain_.vec3(env) * Real(attitude_share_), error_(left));
    return control::clamp_symmetric(rate, max_rate_.vec3());
  }

  /// Rotor speeds for thrust [N] and torque [N m], B axes. About z, most of the torque comes from
  /// the rotors' acceleration; the torque of their drag follows later.
  template <class Real>
  SKYBODY_INLINE void drive(State<Real>& state, const Real& thrust, const Vec3<Real>& torque,
                            Values<Real> output) const {
    const Real reaction = state.reaction + (torque.z - state.reaction) * reaction_share_;
    allocation_.thrusts(clamp(thrust, Real(0.0), Real(limits_.thrust)),
                        Vec3<Real>{torque.x, torque.y, reaction}, output);
    const Real given = allocation_.speeds_and_yaw(output);
    // a NaN command does not enter the state
    state.reaction = select(is_nan(given), state.reaction, given);
  }

  int velocity_place() const { return rotors_.count(); }

  /// Index in the buffer, after the rotors' speeds: velocity at the last call, then the force
  /// filter's state.
  static constexpr int kLinearWords = 9;

  TextParameter signal_{
      this, choice("signal", "trajectory", {"trajectory", "attitude", "ctbr"}, "input signal")};
  BooleanParameter feed_forward_{
      this, boolean("feed_forward", false, "attitude: also read the desired attitude's rates")};
  IntegerParameter period_{this, integer("period", "physics steps", 0, between(0, 1000),
                                         "interval of evaluations; 0: as many as fit into 2 ms")};
  RealParameter cutoff_{this,
                        real("cutoff", "Hz", 30.0, at_least(1e-3),
                             "cutoff of the filter on measured accelerations and rotor effects")};
  control::MeasuredMotion measured_{this};
  RealsParameter rate_gain_{
      this, randomizable(reals("rate_gain", "1/s", {kRateGain, kRateGain, 10.0}, at_least(0.0),
                               "angular acceleration per rate error, base axes"))};
  RealsParameter attitude_gain_{
      this, randomizable(reals("attitude_gain", "1/s", {10.0, 10.0, 4.0}, at_least(0.0),
                               "rate per attitude error, base axes"))};
  RealsParameter kp_{this,
                     randomizable(reals("kp", "1/s^2", {8.0, 8.0, 12.0}, at_least(0.0),
                                        "trajectory: acceleration per position error, W axes"))};
  RealsParameter kd_{this,
                     randomizable(reals("kd", "1/s", {4.8, 4.8, 6.5}, at_least(0.0),
                                        "trajectory: acceleration per velocity error, W axes"))};
  RealParameter max_error_{
      this, real("max_error", "m", 1.0, at_least(1e-3),
                 "trajectory: limit of the position error in the feedback, each axis")};
  RealsParameter max_rate_{this,
                           reals("max_rate", "rad/s", {10.0, 10.0, 5.0}, between(1e-6, 1000.0),
                                 "limits of the commanded rates, without feed-forward")};
  control::AttitudeErrorChoice error_{this};
  control::LimitReport report_;
  control::AccelerationLimits acceleration_{this, {.side = 20.0, .up = 10.0, .down = 8.0}};
  control::TrajectoryInput trajectory_{this};
  control::AllocationChoice allocation_choice_{this};

  Level level_ = Level::kTrajectory;
  control::Allocation allocation_;
  control::ThrustTorqueLimits limits_;
  control::LowPass filter_;
  RotorEfforts rotors_;
  SymMat3<double> inertia_{};
  int base_ = 0;
  double mass_ = 0.0, interval_ = 0.0, per_interval_ = 0.0;
  double reaction_share_ = 1.0;
  double rate_share_ = 1.0, attitude_share_ = 1.0, kp_share_ = 1.0, kd_share_ = 1.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Indi, "indi", "1.0.0",
               "Follows a trajectory, attitude or rates by incremental dynamic inversion of "
               "measured accelerations.");
