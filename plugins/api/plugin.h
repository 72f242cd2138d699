// The base classes of plugins: Controller, Sensor, Randomizer, Task, Effect.
//
// A plugin is one class. Its parameters are members (parameter.h). configure() looks up names and
// declares inputs and outputs. The step methods are const and work on State, which the host owns.
// `template <class Real> struct State` holds only Real, Word<Real>, Vec3<Real>, Quat<Real> and
// arrays of them. A step method that is a template on Real serves several environments at once; one
// written for plain double serves one lane after the other, with the same result. Every step method
// may take the instance's buffer (Setup::buffer) as a last argument, `Values<Real> buffer`. Helper
// functions on Real must be templates in the plugin's own file or in headers: all code is inlined
// into functions of one instruction set.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/math/random.h"
#include "plugins/api/env_view.h"
#include "plugins/api/parameter.h"
#include "plugins/api/setup.h"

namespace skybody {

/// Common base of all plugin classes. An instance is immutable after configure().
class Plugin {
 public:
  Plugin() = default;
  Plugin(const Plugin&) = delete;
  Plugin& operator=(const Plugin&) = delete;
  virtual ~Plugin() = default;

  /// Looks up names, checks the world, declares inputs and outputs. Parameters have their values.
  /// Throws std::runtime_error with a message for the user if the plugin cannot serve the scenario.
  virtual void configure(const Setup& setup) = 0;

  /// Whether each step method is differentiable almost everywhere with respect to its inputs. A
  /// controller, an effect or a task whose methods are templates on Real declares this by
  ///   static constexpr bool kSmooth = true;
  /// The library then compiles its methods for dual numbers too, for derivatives through them.
  /// Counters, random numbers and the results of `any`, `all` and `none` are treated as constants.
  static constexpr bool kSmooth = false;

  /// State of an instance per environment: Real, Word<Real>, Vec3<Real>, Quat<Real> and arrays of
  /// them. The host owns it. All words are 0 at the start of an episode, except in randomizers.
  /// Empty unless the derived class declares its own.
  template <class Real>
  struct State {};

  /// For the library: the parameter members, in the order of their declaration.
  const std::vector<Parameter*>& parameters() const { return parameters_; }

  /// Called by the host before configure(): sets the key of this instance's random numbers.
  void set_stream(std::uint64_t stream) { stream_ = stream; }

 protected:
  /// Random numbers that depend only on seed, stream env, episode, this instance, physics step and
  /// `substream`: two calls of one instance with equal values of these give the same numbers. The
  /// physics step is the number of completed steps. Several methods of an instance are called at
  /// the same physics step and need different substreams for independent draws:
  ///   - step 0: a controller's reset() and first control(), a sensor's reset() and first sense(),
  ///     an effect's reset() and first apply(), a task's reset(), first evaluate() and first
  ///     process();
  ///   - later steps: a task's evaluate() and the process() that follows.
  /// Draws on request in mid-episode (Start::requested), and starts that are redrawn because a
  /// robot began inside another shape, use their own counters in place of the physics step.
  template <class Real>
  Random<Real> random(const EnvView<Real>& env, std::uint64_t substream = 0) const {
    return random_at(env, env.physics_step(), substream);
  }
  /// The numbers of random() at another physics step of the episode: to draw those of skipped calls
  /// (Setup::only_when_read).
  template <class Real>
  Random<Real> random_at(const EnvView<Real>& env, const Word<Real>& physics_step,
                         std::uint64_t substream = 0) const {
    return Random<Real>(env.seed(), env.stream_env(), env.episode(), physics_step,
                        stream_ + substream, bits_from_mask(env.served()));
  }
  /// The same for all lanes of the view, served or not: for values stored in EnvView::memo().
  template <class Real>
  Random<Real> random_of_all(const EnvView<Real>& env, const Word<Real>& physics_step,
                             std::uint64_t substream = 0) const {
    return Random<Real>(env.seed(), env.stream_env(), env.episode(), physics_step,
                        stream_ + substream);
  }

 private:
  friend class Parameter;
  std::vector<Parameter*> parameters_;
  std::uint64_t stream_ = 0;
};

/// Maps a command to another command, or to actuators. `configure()` declares Setup::input() and
/// Setup::output().
///
/// Required; called before every physics step, or before every Setup::period() of them:
///   template <class Real>
///   void control(const EnvView<Real>& env, State<Real>& state, ConstValues<Real> input,
///                Values<Real> output) const;
/// `input` has the values of Setup::input(), in physical units. `output` has those of
/// Setup::output(); all of them must be written.
///
/// Optional; called at a reset, when the robots have been placed and all State is 0:
///   template <class Real> void reset(const EnvView<Real>& env, State<Real>& state) const;
class Controller : public Plugin {
 public:
  static constexpr SkybodyKind kKind = SKYBODY_CONTROLLER;
};

/// Measures. `configure()` declares Setup::channel() for each output, and optionally
/// Setup::image().
///
/// Required; called at a reset and after every physics step, or every Setup::period() of them:
///   template <class Real>
///   void sense(const EnvView<Real>& env, State<Real>& state, Values<Real> output) const;
/// `output` has the values of all channels in order; they stay until the next call. A sensor with
/// images is also called after a restore: see EnvView::draws_again().
///
/// Optional; called at a reset before the first sense():
///   template <class Real> void reset(const EnvView<Real>& env, State<Real>& state) const;
class Sensor : public Plugin {
 public:
  static constexpr SkybodyKind kKind = SKYBODY_SENSOR;
};

/// State that a randomizer may change at a reset.
template <class Real>
class Start {
 public:
  Start(const Values<Real>& q_values, const Values<Real>& u_values,
        const Values<Real>& rotor_speed_values, const Values<Real>& param_values,
        std::uint32_t occasion)
      : q(q_values),
        u(u_values),
        rotor_speed(rotor_speed_values),
        params(param_values),
        requested(occasion == SKYBODY_ON_REQUEST),
        in_time(occasion == SKYBODY_IN_TIME) {}

  /// Joint coordinates of the world, at BodyInfo::first_q [m] and [rad]. A free base: position (W)
  /// and quaternion w x y z.
  Values<Real> q;
  /// Their rates, at BodyInfo::first_u [m/s] and [rad/s]. A free base: velocity (W axes) and
  /// angular velocity (B axes).
  Values<Real> u;
  Values<Real> rotor_speed;  ///< of every rotor of the world [rad/s], >= 0
  /// Randomizable values, at Setup::find_params(). Only those announced by Setup::writes() may be
  /// written; they are held to their bounds afterwards.
  Values<Real> params;
  bool requested;  ///< the caller requests a draw now, whatever the schedule
  bool in_time;    ///< before a physics step (Setup::draws_in_time): only parameters may change
};

/// Draws values at the start of an episode. `configure()` declares the parameters that it may write
/// by Setup::writes(). A randomizer's State survives resets, so that it may count them.
///
/// Required; called at every reset, in the order of the scenario. The robots have been placed by
/// the current parameters `robots.NAME.start...`; parameters have their previously drawn values.
/// Robots move to the starts that it writes as soon as it returns:
///   template <class Real>
///   void randomize(const EnvView<Real>& env, State<Real>& state, Start<Real>& start) const;
class Randomizer : public Plugin {
 public:
  static constexpr SkybodyKind kKind = SKYBODY_RANDOMIZER;
};

/// Inputs that an effect adds to the physics of the step that begins; constant over that step. Each
/// must have been declared by Setup::holds(). The contributions of several effects add up.
template <class Real>
class Held {
 public:
  /// @param lanes  lanes of the group, as for EnvView
  Held(const SkybodyHeld& held, const SkybodyLanes& raw, std::uint32_t lanes, std::uint32_t first,
       const MaskOf<Real>& served)
      : held_(held), lanes_(lanes), first_(first), checks_(raw.checks), mask_(served) {}

  /// Velocity of the air around a world body, W [m/s]; for rotor drag, rolling moment, body drag.
  void add_wind(int body, const Vec3<Real>& velocity) { add(SKYBODY_HELD_WIND, body, 0, velocity); }
  /// Force [N] at the body's centre of mass and moment [N m], W axes.
  void add_wrench(int body, const Vec3<Real>& force, const Vec3<Real>& moment) {
    add(SKYBODY_HELD_WRENCH, body, 0, force);
    add(SKYBODY_HELD_WRENCH, body, 3, moment);
  }
  /// Drag at the body's centre of mass, which moves through the air at v, along each body axis i:
  ///   F_i = -(linear_i + quadratic_i |v|) v_i, in [N s/m] and [N s^2/m^2].
  void add_drag(int body, const Vec3<Real>& linear, const Vec3<Real>& quadratic) {
    add(SKYBODY_HELD_BODY_DRAG, body, 0, linear);
    add(SKYBODY_HELD_BODY_DRAG, body, 3, quadratic);
  }
  /// Factor on the thrust of a world rotor.
  void scale_thrust(int rotor, const Real& gain) { scale(rotor, SKYBODY_GAIN_THRUST, gain); }
  /// Factor on a rotor's reaction moment about its axis.
  void scale_moment(int rotor, const Real& gain) { scale(rotor, SKYBODY_GAIN_MOMENT, gain); }
  /// Factor on a rotor's drag across its axis.
  void scale_rotor_drag(int rotor, const Real& gain) { scale(rotor, SKYBODY_GAIN_DRAG, gain); }
  /// Factor on a rotor's rolling moment.
  void scale_rolling_moment(int rotor, const Real& gain) {
    scale(rotor, SKYBODY_GAIN_ROLLING, gain);
  }
  /// Flow at a rotor's hub, at speed w, with v the hub's velocity through the air and n the axis:
  /// force -axial_drag w (v . n) n [N s^2/(m rad)] and lift |v - (v . n) n|^2 n [N s^2/m^2], moment
  /// -flapping w v x n [N s^2/rad].
  void add_rotor_flow(int rotor, const Real& axial_drag, const Real& flapping, const Real& lift) {
    add(SKYBODY_HELD_ROTOR_FLOW, rotor, 0, Vec3<Real>{axial_drag, flapping, lift});
  }
  /// Bounds of a rotor's command, and of its speed if an acceleration is set [rad/s], in addition
  /// to its own limits; the narrowest bounds apply. A speed out of bounds returns with the rotor's
  /// lag.
  void limit_speed(int rotor, const Real& least, const Real& greatest) {
    const Values<Real> limit = values(SKYBODY_HELD_ROTOR_LIMIT);
    const int k = kSizes[SKYBODY_HELD_ROTOR_LIMIT] * rotor;
    limit.set(k, max(limit[k], least));
    limit.set(k + 1, min(limit[k + 1], greatest));
  }
  /// Acceleration of a rotor [rad/s^2] in place of its first-order lag (paper eq. 2). The last
  /// effect that sets it wins.
  void set_acceleration(int rotor, const Real& acceleration) {
    values(SKYBODY_HELD_ROTOR_RATE).set(kSizes[SKYBODY_HELD_ROTOR_RATE] * rotor, acceleration);
  }

 private:
  /// Values per owner of each input.
  static constexpr int kSizes[] = {
#define SKYBODY_ROW(symbol, type, member, owner, size, doc) size,
      SKYBODY_HELD_INPUTS(SKYBODY_ROW)
#undef SKYBODY_ROW
  };
  /// Whether rotors own the values of each input; otherwise bodies do.
  static constexpr bool kIsOfRotors[] = {
#define SKYBODY_ROW(symbol, type, member, owner, size, doc) std::string_view(#owner) == "rotor",
      SKYBODY_HELD_INPUTS(SKYBODY_ROW)
#undef SKYBODY_ROW
  };

  /// Of size 0 if the effect did not declare the input.
  Values<Real> values(SkybodyHeldInput input) const {
    double* const data = held_.input[input];
    if (checks_ == nullptr) return {data + first_, lanes_, mask_};
    const int count = kSizes[input] * (kIsOfRotors[input] ? checks_->rotors : checks_->bodies);
    return {data, lanes_, mask_, Bounds<Real>(checks_, "held input", data == nullptr ? 0 : count)};
  }
  /// @param part  first of the body's values that get `value`
  void add(SkybodyHeldInput input, int body, int part, const Vec3<Real>& value) {
    const Values<Real> sums = values(input);
    const int k = kSizes[input] * body + part;
    sums.set(k, sums.vec3(k) + value);
  }
  void scale(int rotor, SkybodyRotorGain place, const Real& gain) {
    const Values<Real> gains = values(SKYBODY_HELD_ROTOR_GAIN);
    const int k = kSizes[SKYBODY_HELD_ROTOR_GAIN] * rotor + place;
    gains.set(k, gains[k] * gain);
  }

  SkybodyHeld held_;
  std::uint32_t lanes_, first_;
  SkybodyChecks* checks_;
  MaskOf<Real> mask_;
};

/// Acts on bodies and rotors in addition to the controllers: wind, drag, a sagging battery.
/// `configure()` declares its inputs by Setup::holds().
///
/// Required; called after the controllers before every physics step, or every Setup::period() of
/// them, or when parameters change (Setup::steady()). Its output holds until the next call:
///   template <class Real>
///   void apply(const EnvView<Real>& env, State<Real>& state, Held<Real>& held) const;
///
/// Optional; called at a reset, after controllers and the task:
///   template <class Real> void reset(const EnvView<Real>& env, State<Real>& state) const;
class Effect : public Plugin {
 public:
  static constexpr SkybodyKind kKind = SKYBODY_EFFECT;
};

/// Results of a task after a step.
template <class Real>
class Evaluation {
 public:
  Evaluation(const Values<Real>& observation_row, const Values<Real>& info_row,
             const Values<Real>& reward, const Values<Real>& robot_rewards, std::uint64_t* end,
             const MaskOf<Real>& mask, bool wants_info)
      : observation(observation_row),
        info(info_row),
        wants_info_(wants_info),
        reward_(reward),
        robot_rewards_(robot_rewards),
        end_(end),
        mask_(mask) {}

  Values<Real> observation;  ///< channels as declared, in order, in their units
  Values<Real> info;         ///< Setup::info() values as declared, in order

  /// Whether `info` will be read. If not, it need not be written.
  bool wants_info() const { return wants_info_; }

  /// The reward of the environment or of the team.
  void set_reward(const Real& reward) { reward_.set(0, reward); }
  /// The reward of one robot, for tasks that called Setup::robot_rewards().
  void set_reward(int robot, const Real& reward) { robot_rewards_.set(robot, reward); }
  /// Ends the episode where `ended` holds: a failure or success of the task.
  void terminate(const MaskOf<Real>& ended) { add_end(ended, 1); }
  /// Cuts the episode short where `cut` holds: says nothing about the value of the state.
  void truncate(const MaskOf<Real>& cut) { add_end(cut, 2); }

 private:
  void add_end(const MaskOf<Real>& where, std::uint64_t bit) {
    const Word<Real> old = load_words<Real>(end_);
    store_words(end_, select(logical_and(where, mask_), old | Word<Real>(bit), old));
  }
  bool wants_info_;
  Values<Real> reward_;
  Values<Real> robot_rewards_;
  std::uint64_t* end_;
  MaskOf<Real> mask_;
};

/// Defines observation, reward and end of episodes. `configure()` declares Setup::channel() for
/// each part of the observation.
///
/// Required; called after every step, and once after a reset, where reward and end are ignored:
///   template <class Real>
///   void evaluate(const EnvView<Real>& env, State<Real>& state, Evaluation<Real>& out) const;
///
/// Optional; called at a reset, when the robots have been placed: draws the task's randomizable
/// parameters, such as a target, that it has declared by Setup::writes(). Callers may change them
/// in the same reset and in flight, so evaluate() must read them at each call (EnvView::param()):
///   template <class Real>
///   void randomize(const EnvView<Real>& env, State<Real>& state, Start<Real>& start) const;
///
/// Optional; called at a reset after that:
///   template <class Real> void reset(const EnvView<Real>& env, State<Real>& state) const;
///
/// Optional; computes the chains' commands, in physical units, once per step or every
/// Setup::period() physics steps. Without it each chain's first controller scales its part of the
/// action. `action` has values in [-1, 1]; after Setup::action() it has physical values, and
/// process() is required:
///   template <class Real>
///   void process(const EnvView<Real>& env, State<Real>& state, ConstValues<Real> action,
///                Values<Real> command) const;
///
/// Required after Setup::goal(); position (W) [m] and yaw [rad], four values for each goal in
/// order, for tables and the `hold` baseline. For plain double:
///   void goal(const EnvView<double>& env, const State<double>& state, Values<double> goal) const;
///
/// Optional for moving goals; velocity (W) [m/s] and acceleration (W) [m/s^2], six values for each
/// goal in order, which the `hold` baseline feeds forward. For plain double:
///   void goal_motion(const EnvView<double>& env, const State<double>& state,
///                    Values<double> motion) const;
class Task : public Plugin {
 public:
  static constexpr SkybodyKind kKind = SKYBODY_TASK;
};

}  // namespace skybody

#include "plugins/api/parameter_inl.h"  // IWYU pragma: export
