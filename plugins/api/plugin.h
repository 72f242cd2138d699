// The classes that authors derive from: Controller, Sensor, Randomizer, Task, Effect.
//
// A plugin is one class. Its parameters are members (parameter.h); configure() looks names up and
// declares what it takes and gives; the step methods are const and work on State, which the host
// owns. `template <class Real> struct State` holds only Real, Word<Real>, Vec3<Real>, Quat<Real>
// and arrays of them. A step method that is a template on Real runs for several environments side
// by side; one written for plain double runs lane after lane, with the same result. Every step
// method may take the instance's buffer (Setup::buffer) as a last argument, `Values<Real> buffer`.
// Helper functions on Real must be templates in the plugin's own file or in headers: everything is
// inlined into functions of one instruction set.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/random.h"
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
  /// Throws std::runtime_error with a text for the user where the scenario cannot be served.
  virtual void configure(const Setup& setup) = 0;

  /// Whether each step method is differentiable almost everywhere in what it reads. A controller,
  /// an effect or a task whose methods are templates on Real declares this by
  ///   static constexpr bool kSmooth = true;
  /// The library then compiles its methods for dual numbers too, so that derivatives can be taken
  /// through them. Counters, random numbers and the answers of `any`, `all` and `none` are
  /// constants there.
  static constexpr bool kSmooth = false;

  /// What an instance remembers of each environment: Real, Word<Real>, Vec3<Real>, Quat<Real> and
  /// arrays of them. The host owns it; all words are 0 when an episode begins, but for randomizers.
  /// None, unless the derived class declares its own.
  template <class Real>
  struct State {};

  /// For the library: the parameter members, in the order of their declaration.
  const std::vector<Parameter*>& parameters() const { return parameters_; }

  /// Called by the host before configure(): names this instance's random numbers.
  void set_stream(std::uint64_t stream) { stream_ = stream; }

 protected:
  /// Random numbers that depend on (seed, stream env, episode, this instance, physics step,
  /// `substream`) only: two calls of one instance with the same of all these give the same numbers.
  /// The physics step is the number of those completed. So one number serves several methods of an
  /// instance, which need different substreams if their draws are to be independent:
  ///   - 0: a controller's reset() and first control(), a sensor's reset() and first sense(), an
  ///     effect's reset() and first apply(), a task's reset(), first evaluate() and first
  ///     process();
  ///   - later: a task's evaluate() and the process() that follows.
  /// Draws that are asked for in mid-episode (Start::requested), and starts that are drawn again
  /// since a robot began inside something, have counts of their own in place of the physics step.
  template <class Real>
  Random<Real> random(const EnvView<Real>& env, std::uint64_t substream = 0) const {
    return random_at(env, env.physics_step(), substream);
  }
  /// The numbers that random() gives in another physics step of the episode: for what a call makes
  /// up for (Setup::only_when_read).
  template <class Real>
  Random<Real> random_at(const EnvView<Real>& env, const Word<Real>& physics_step,
                         std::uint64_t substream = 0) const {
    return Random<Real>(env.seed(), env.stream_env(), env.episode(), physics_step,
                        stream_ + substream, bits_from_mask(env.served()));
  }
  /// The same for all lanes of the view, served or not: for what goes into EnvView::memo().
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

/// Maps a command to another one, or to actuators. `configure()` declares Setup::input() and
/// Setup::output().
///
/// Required; called before every physics step, or before every Setup::period() of them:
///   template <class Real>
///   void control(const EnvView<Real>& env, State<Real>& state, ConstValues<Real> input,
///                Values<Real> output) const;
/// `input` has the values of Setup::input(), in physical units; `output` those of Setup::output()
/// and has to be written whole.
///
/// Optional; called at a reset, when the robots have been placed and all State is 0:
///   template <class Real> void reset(const EnvView<Real>& env, State<Real>& state) const;
class Controller : public Plugin {
 public:
  static constexpr SkybodyKind kKind = SKYBODY_CONTROLLER;
};

/// Measures. `configure()` declares Setup::channel() for each output, and perhaps Setup::image().
///
/// Required; called at a reset and after every physics step, or every Setup::period() of them:
///   template <class Real>
///   void sense(const EnvView<Real>& env, State<Real>& state, Values<Real> output) const;
/// `output` has the values of all channels in order; they stay until the next call.
///
/// Optional; called at a reset before the first sense():
///   template <class Real> void reset(const EnvView<Real>& env, State<Real>& state) const;
class Sensor : public Plugin {
 public:
  static constexpr SkybodyKind kKind = SKYBODY_SENSOR;
};

/// What a randomizer may change at a reset.
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
  bool requested;  ///< the caller asks for a draw now, whatever the schedule says
  bool in_time;    ///< before a physics step (Setup::draws_in_time): parameters alone may change
};

/// Draws values when an episode begins. `configure()` announces the parameters that it may write by
/// Setup::writes(). A randomizer's State survives resets, so that it may count them.
///
/// Required; called at every reset, after the robots were placed where the present parameters
/// `robots.NAME.start...` say, in the order of the scenario. Parameters have what was drawn before.
/// Robots go to the starts that it writes as soon as it returns:
///   template <class Real>
///   void randomize(const EnvView<Real>& env, State<Real>& state, Start<Real>& start) const;
class Randomizer : public Plugin {
 public:
  static constexpr SkybodyKind kKind = SKYBODY_RANDOMIZER;
};

/// What an effect adds to the physics of the step that begins; constant over it. Each input must
/// have been announced by Setup::holds(). Effects add to one another.
template <class Real>
class Held {
 public:
  /// @param lanes  of the group, as for EnvView
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
  /// What the air at a rotor's hub does to it, at speed w with v the hub's velocity through the air
  /// and n the axis: force -axial_drag w (v . n) n [N s^2/(m rad)] and lift |v - (v . n) n|^2 n
  /// [N s^2/m^2], moment -flapping w v x n [N s^2/rad].
  void add_rotor_flow(int rotor, const Real& axial_drag, const Real& flapping, const Real& lift) {
    add(SKYBODY_HELD_ROTOR_FLOW, rotor, 0, Vec3<Real>{axial_drag, flapping, lift});
  }
  /// Bounds of a rotor's command, and of its speed where an acceleration is set [rad/s], besides
  /// its own limit; the narrowest of all holds. What is beyond them comes there by its lag.
  void limit_speed(int rotor, const Real& least, const Real& greatest) {
    const Values<Real> limit = values(SKYBODY_HELD_ROTOR_LIMIT);
    const int k = kSizes[SKYBODY_HELD_ROTOR_LIMIT] * rotor;
    limit.set(k, max(limit[k], least));
    limit.set(k + 1, min(limit[k + 1], greatest));
  }
  /// Acceleration of a rotor [rad/s^2] in place of its first-order lag (paper eq. 2); of several
  /// effects the last one's.
  void set_acceleration(int rotor, const Real& acceleration) {
    values(SKYBODY_HELD_ROTOR_RATE).set(kSizes[SKYBODY_HELD_ROTOR_RATE] * rotor, acceleration);
  }

 private:
  /// Of each input: values for each owner.
  static constexpr int kSizes[] = {
#define SKYBODY_ROW(symbol, type, member, owner, size, doc) size,
      SKYBODY_HELD_INPUTS(SKYBODY_ROW)
#undef SKYBODY_ROW
  };
  /// Of each input: whether the rotors own its values, else the bodies.
  static constexpr bool kIsOfRotors[] = {
#define SKYBODY_ROW(symbol, type, member, owner, size, doc) std::string_view(#owner) == "rotor",
      SKYBODY_HELD_INPUTS(SKYBODY_ROW)
#undef SKYBODY_ROW
  };

  /// Of size 0 where the effect did not announce the input.
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

/// Acts on bodies and rotors beside the controllers: wind, drag, a sagging battery. `configure()`
/// announces what it holds by Setup::holds().
///
/// Required; called after the controllers before every physics step, or every Setup::period() of
/// them, or where parameters change (Setup::steady()). What it adds holds until its next call:
///   template <class Real>
///   void apply(const EnvView<Real>& env, State<Real>& state, Held<Real>& held) const;
///
/// Optional; called at a reset, after controllers and the task:
///   template <class Real> void reset(const EnvView<Real>& env, State<Real>& state) const;
class Effect : public Plugin {
 public:
  static constexpr SkybodyKind kKind = SKYBODY_EFFECT;
};

/// What a task gives after a step.
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

  /// Whether anybody will look at `info`. Where not, it need not be written.
  bool wants_info() const { return wants_info_; }

  /// The environment's reward; of a team, the team's.
  void set_reward(const Real& reward) { reward_.set(0, reward); }
  /// One robot's own, for tasks that called Setup::robot_rewards().
  void set_reward(int robot, const Real& reward) { robot_rewards_.set(robot, reward); }
  /// Ends the episode where `ended` holds: a failure or success of the task.
  void terminate(const MaskOf<Real>& ended) { add_end(ended, 1); }
  /// Cuts the episode short where `cut` holds: no statement about the value of the state.
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
/// Optional; called at a reset, when the robots have been placed: draws randomizable parameters of
/// its own, such as a target, that it has announced by Setup::writes(). Callers may change them in
/// the same reset and in flight, so evaluate() reads them anew (EnvView::param()):
///   template <class Real>
///   void randomize(const EnvView<Real>& env, State<Real>& state, Start<Real>& start) const;
///
/// Optional; called at a reset after that:
///   template <class Real> void reset(const EnvView<Real>& env, State<Real>& state) const;
///
/// Optional; makes the chains' commands, in physical units, once a step or every Setup::period()
/// physics steps. Without it each chain's first controller scales its part of the action. `action`
/// has values in [-1, 1]; after Setup::action() it has physical values, and process() is required:
///   template <class Real>
///   void process(const EnvView<Real>& env, State<Real>& state, ConstValues<Real> action,
///                Values<Real> command) const;
///
/// Required after Setup::goal(); position (W) [m] and yaw [rad], four values for each goal in
/// order, for tables and the `hold` baseline. For plain double:
///   void goal(const EnvView<double>& env, const State<double>& state, Values<double> goal) const;
///
/// Optional where goals move; velocity (W) [m/s] and acceleration (W) [m/s^2], six values for each
/// goal in order, which the `hold` baseline feeds forward. For plain double:
///   void goal_motion(const EnvView<double>& env, const State<double>& state,
///                    Values<double> motion) const;
class Task : public Plugin {
 public:
  static constexpr SkybodyKind kKind = SKYBODY_TASK;
};

}  // namespace skybody

#include "plugins/api/parameter_inl.h"  // IWYU pragma: export
