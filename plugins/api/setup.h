// The world as a plugin's configure() sees it, and what it declares there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/vec3.h"
#include "plugins/api/abi.h"
#include "plugins/api/image.h"  // IWYU pragma: export
#include "plugins/api/text.h"   // IWYU pragma: export

namespace skybody {

using RobotInfo = SkybodyRobotInfo;
using BodyInfo = SkybodyBodyInfo;
using LinkInfo = SkybodyLinkInfo;
using RotorInfo = SkybodyRotorInfo;
using EnvParamInfo = SkybodyEnvParamInfo;
using ChainInfo = SkybodyChainInfo;
using ShapeInfo = SkybodyShapeInfo;

/// Signals between controllers; sizes, units and frames in signals.h.
enum class Signal {
#define SKYBODY_ROW(symbol, type, word, least, most, doc) k##type = SKYBODY_##symbol,
  SKYBODY_SIGNALS(SKYBODY_ROW)
#undef SKYBODY_ROW
};

/// What an effect holds over a physics step; values in core/base/held_inputs.h.
enum class HeldInput {
#define SKYBODY_ROW(symbol, type, member, owner, size, doc) k##type = SKYBODY_HELD_##symbol,
  SKYBODY_HELD_INPUTS(SKYBODY_ROW)
#undef SKYBODY_ROW
};

/// What a body may touch.
enum class Partner {
  kGroundPlane = SKYBODY_GROUND,
  kBody = SKYBODY_OTHER_BODY,
  kObstacle = SKYBODY_OBSTACLE,
};

/// A contiguous array that belongs to the host. Valid during configure(): copy what is needed
/// later.
template <class T>
class View {
 public:
  View(const T* data, int size) : data_(data), size_(size) {}
  /// For `for (const T& x : view)`.
  const T* begin() const { return data_; }
  /// Behind the last element.
  const T* end() const { return data_ + size_; }
  /// Element i, 0 <= i < size(); not checked.
  const T& operator[](int i) const { return data_[i]; }
  /// Number of elements.
  int size() const { return size_; }

 private:
  const T* data_;
  int size_;
};

/// Passed to configure(). Valid during that call, and so is all that it refers to: names, views,
/// infos. A plugin refuses a scenario by throwing any
/// std::exception: its text becomes the error at the scenario's line.
class Setup {
 public:
  Setup(const SkybodySetup& raw, const SkybodyDeclare& declare) : raw_(raw), declare_(declare) {}

  /// This instance's path, such as `robots.quad.controllers.ctbr`.
  std::string instance() const { return raw_.instance; }
  double dt() const { return raw_.dt; }                     ///< physics step [s]
  int action_repeat() const { return raw_.action_repeat; }  ///< physics steps an action
  int horizon() const { return raw_.horizon; }              ///< steps an episode, 0: unlimited
  const double* gravity() const { return raw_.gravity; }    ///< 3 values, W [m/s^2]; nominal

  /// All robots, in the order of the scenario.
  View<RobotInfo> robots() const { return {raw_.robots, raw_.robot_count}; }
  /// All bodies: robot after robot, of each the base first and parents before children.
  View<BodyInfo> bodies() const { return {raw_.bodies, raw_.body_count}; }
  /// All links that belong to a body, robot after robot, in the order of the URDF.
  View<LinkInfo> links() const { return {raw_.links, raw_.link_count}; }
  /// All rotors: robot after robot, in the order of the rotors file.
  View<RotorInfo> rotors() const { return {raw_.rotors, raw_.rotor_count}; }
  /// All randomizable values, in the order of EnvView::param().
  View<EnvParamInfo> params() const { return {raw_.params, raw_.param_count}; }
  /// Tasks and randomizers: the chains of controllers, in robot order. Empty for others.
  View<ChainInfo> chains() const { return {raw_.chains, raw_.chain_count}; }
  /// Collision shapes of bodies, in body order, then obstacles; a shape's place is its id. Where an
  /// obstacle is in an environment, how large, and whether: EnvView::param() from first_param on.
  View<ShapeInfo> shapes() const { return {raw_.shapes, raw_.shape_count}; }

  /// Controllers: the robots that this one serves, by index: its own, or those of its team, in the
  /// order in which the team lists them. Empty for others.
  View<std::int32_t> team() const { return {raw_.team, raw_.team_size}; }
  /// Controllers: index of the one robot that this one serves.
  /// @throws std::runtime_error if that is a team of several; std::logic_error for other kinds
  int robot() const;
  /// Index of the robot called `name`; an empty name means the only one.
  /// @throws std::runtime_error naming those that exist
  int robot(const std::string& name) const;
  /// The rotors of one robot: world rotor indices [first, first + count).
  View<RotorInfo> rotors_of(int robot) const;
  /// A link of a robot. @throws std::runtime_error naming those that exist
  const LinkInfo& link(int robot, const std::string& name) const;
  /// The body of a robot that the joint of that name moves. @throws std::runtime_error naming those
  /// that exist
  const BodyInfo& joint(int robot, const std::string& name) const;
  /// Its world body index.
  int index_of(const BodyInfo& body) const { return static_cast<int>(&body - raw_.bodies); }
  /// Index for EnvView::sensor() of the first value of a sensor's channel, and its size. Says that
  /// the plugin reads it.
  /// @throws std::runtime_error naming those that exist
  int sensor(const std::string& instance, const std::string& channel, int* count = nullptr) const;
  /// Indices for EnvView::param() of the parameters that `path` means. A path may begin with
  /// `robot.` for every robot, and with `controllers.`, `sensors.`, `task.` for plugins; `[*]`
  /// means all elements, `*` elsewhere any part of a name, or nothing: `kp*` is `kp`, too.
  /// @throws std::runtime_error if nothing matches
  std::vector<int> find_params(const std::string& path) const;

  /// Controllers: the command taken; `low` and `high`, one value for each of the command, are what
  /// actions -1 and +1 mean [the signal's units]. @throws std::logic_error if their sizes differ
  void input(Signal signal, const std::vector<double>& low, const std::vector<double>& high) const;
  /// Controllers that pass their command on to the one behind them: actions -1 and +1 mean what
  /// they mean there. One that nothing follows which has a range is refused when the scenario is
  /// loaded.
  void input(Signal signal, int count) const;
  /// Controllers: what control() writes, `count` values. The last one of a chain may give several
  /// signals to actuators: their values follow one another in the order of these calls.
  /// @param robot  which of team() it is for; -1: the first. What takes it: another controller of
  ///               the team, that robot's own chain, or its actuators
  void output(Signal signal, int count, int robot = -1) const;
  /// Controllers with output Signal::kWrench: where values 6 i to 6 i + 5 act, for site i = 0, 1,
  /// ...
  void site(const SkybodySite& site) const { declare_.site(declare_.host, &site); }
  /// Controllers with output Signal::kJoint: what value i drives, for drive i = 0, 1, ... A
  /// coordinate has one drive.
  void joint(const SkybodyJointDrive& drive) const { declare_.joint(declare_.host, &drive); }
  /// Effects: announces an input that apply() adds to, by the methods of Held.
  void holds(HeldInput input) const { declare_.holds(declare_.host, static_cast<int>(input)); }
  /// Sensors and tasks: a part of the output or observation, in order: `count` values in `unit`,
  /// with bounds for the space (infinite where there are none).
  /// @param robot  whose own observation it belongs to, -1: every robot's
  /// @param doc    what the values are, for tables of columns
  void channel(const std::string& name, const std::string& unit, int count, double low, double high,
               int robot = -1, const std::string& doc = "") const;
  /// The same for a critic only: an observed value that the policy does not see.
  void privileged_channel(const std::string& name, const std::string& unit, int count, double low,
                          double high, int robot = -1, const std::string& doc = "") const;
  /// Tasks: `count` values of the observation from `to` on are those from `from` on, none of them
  /// privileged or a repeat itself. Where kLeavesRepeats<Real> a task need not write them.
  void repeat(int to, int from, int count) const {
    declare_.repeat(declare_.host, to, from, count);
  }
  /// Sensors: an image, which is written through EnvView::pixels(). It is no value of
  /// EnvView::sensor().
  /// @tparam T     std::uint8_t, std::uint16_t or float
  /// @param shape  one to three extents, such as {height, width, channels}; the last varies fastest
  /// @param low, high  bounds for the space; by default those of T
  template <class T>
  Image<T> image(const std::string& name, const std::vector<int>& shape, int robot = -1,
                 double low = kLeast<T>, double high = kGreatest<T>) const;
  /// Tasks: `count` values beside the observation (Evaluation::info), in order: what an evaluation
  /// asks for, such as a position error.
  void info(const std::string& name, const std::string& unit, int count,
            const std::string& doc = "") const;
  /// Controllers, sensors, effects: likewise; the values are words `first` to `first + count - 1`
  /// of the buffer. Their name becomes INSTANCE.NAME.
  void report(const std::string& name, const std::string& unit, int count, int first) const;
  /// Tasks: a part of the action; -1 and +1 mean `low` and `high`. In robot order. Then process()
  /// makes the command from physical values; without these the action is the chains' commands.
  /// @param robot  whose action it is
  void action(const std::string& name, const std::string& unit, int count, double low, double high,
              int robot) const;
  /// Tasks: commands change in equal parts over the physics steps of an action.
  void interpolate() const { declare_.interpolate(declare_.host); }
  /// Tasks: evaluate() gives every robot a reward of its own beside the team's.
  void robot_rewards() const { declare_.robot_rewards(declare_.host); }
  /// Sensors: sense() is called after every `physics_steps` physics steps. Controllers and effects:
  /// before every such step; what they gave holds in between. Default 1. Tasks: process() is called
  /// so often; default: once an action.
  void period(int physics_steps) const { declare_.period(declare_.host, physics_steps); }
  /// `words` doubles of state beside State, for sizes known only now; zero at a reset.
  void buffer(int words) const { declare_.buffer(declare_.host, words); }
  /// `count` values of memory for a call (EnvView::scratch); no state.
  void scratch(int count) const { declare_.scratch(declare_.host, count); }
  /// `count` values of memory that lasts (EnvView::memo); no state.
  void memo(int count) const { declare_.memo(declare_.host, count); }
  /// Effects: what apply() gives follows from parameters alone, the scenario's and
  /// EnvView::param(). It is then called before the first physics step of an episode and where
  /// parameters may have changed, in place of a period; what it gave holds in between.
  void steady() const { declare_.steady(declare_.host); }
  /// Asks for EnvView::contact(), which costs time in large batches.
  void need_contacts() const { declare_.contacts(declare_.host); }
  /// Asks for what a world body feels of one that it may touch, at the same cost.
  /// @param other  of kBody: a world body; of kObstacle: its place among the obstacles in shapes()
  /// @returns the index for EnvView::contact_pair()
  int contact_pair(int body, Partner partner, int other = 0) const {
    return declare_.contact_pair(declare_.host, body, static_cast<int>(partner), other);
  }
  /// Asks for what the inboard joint of a world body exerts on it, which takes the time of another
  /// evaluation of the dynamics in every physics step, lane by lane.
  /// @returns the index for EnvView::joint_reaction()
  int joint_reaction(int body) const { return declare_.joint_reaction(declare_.host, body); }
  /// Sensors: sense() may be left out where nobody would read its output before the next call, over
  /// SKYBODY_LONGEST_LEFT_OUT (1024) physics steps at most. It must give the same whether the calls
  /// before were made or left out: a walk is made up for by Plugin::random_at().
  void only_when_read() const { declare_.only_when_read(declare_.host); }
  /// Asks for EnvView::body_before().
  void need_bodies_before() const { declare_.bodies_before(declare_.host); }
  /// Randomizers, and tasks for parameters of their own: announces that parameter `param` of
  /// params() will be written; it is then held to its bounds after every draw. Two plugins that
  /// announce one are an error of the scenario.
  void writes(int param) const { declare_.writes(declare_.host, param); }
  /// Randomizers: asks to be called before every physics step as well (Start::in_time), to draw
  /// parameters at times within the episode.
  void draws_in_time() const { declare_.draws_in_time(declare_.host); }
  /// Tasks: goal() gives where the frame of world body `body` of `robot` should be. In order; once
  /// a robot at most. Where a tool at the body's end is to be brought to a place, goal() gives that
  /// of the frame with the body turned as it is now, and `point` says which point the tool is.
  /// @param point  in the body's frame [m]
  void goal(int robot, int body, const Vec3<double>& point = {0.0, 0.0, 0.0}) const {
    const double values[3] = {point.x, point.y, point.z};
    declare_.goal(declare_.host, robot, body, values);
  }

  /// For the library: the C structure.
  const SkybodySetup& raw() const { return raw_; }

 private:
  const SkybodySetup& raw_;
  const SkybodyDeclare& declare_;
  mutable std::size_t image_bytes_ = 0;  ///< of the images declared so far
};

}  // namespace skybody

#include "plugins/api/setup_inl.h"
