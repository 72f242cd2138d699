// The world as passed to a plugin's configure(), and the plugin's declarations.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/math/vec3.h"
#include "core/plugin_abi/abi.h"
#include "core/plugin_abi/image.h"  // IWYU pragma: export
#include "plugins/api/refuse.h"     // IWYU pragma: export

namespace skybody {

using RobotInfo = SkybodyRobotInfo;
using BodyInfo = SkybodyBodyInfo;
using LinkInfo = SkybodyLinkInfo;
using RotorInfo = SkybodyRotorInfo;
using EnvParamInfo = SkybodyEnvParamInfo;
using ChainInfo = SkybodyChainInfo;
using ShapeInfo = SkybodyShapeInfo;
using VisualInfo = SkybodyVisualInfo;
using Triangles = SkybodyTriangles;
using PictureInfo = SkybodyPicture;

/// Signals between controllers; sizes, units and frames in signals.h.
enum class Signal {
#define SKYBODY_ROW(symbol, type, word, least, most, doc) k##type = SKYBODY_##symbol,
  SKYBODY_SIGNALS(SKYBODY_ROW)
#undef SKYBODY_ROW
};

/// Inputs that an effect holds constant over a physics step; values in core/base/held_inputs.h.
enum class HeldInput {
#define SKYBODY_ROW(symbol, type, member, owner, size, doc) k##type = SKYBODY_HELD_##symbol,
  SKYBODY_HELD_INPUTS(SKYBODY_ROW)
#undef SKYBODY_ROW
};

/// Possible contact partners of a body.
enum class Partner {
  kGroundPlane = SKYBODY_GROUND,
  kBody = SKYBODY_OTHER_BODY,
  kObstacle = SKYBODY_OBSTACLE,
};

/// A contiguous array owned by the host. Valid during configure(): copy values that you need later.
template <class T>
class View {
 public:
  View(const T* data, int size) : data_(data), size_(size) {}
  /// For `for (const T& x : view)`.
  const T* begin() const { return data_; }
  /// One past the last element.
  const T* end() const { return data_ + size_; }
  /// Element i, 0 <= i < size(); not checked.
  const T& operator[](int i) const { return data_[i]; }
  /// Number of elements.
  int size() const { return size_; }

 private:
  const T* data_;
  int size_;
};

/// Passed to configure(). Valid during that call, including all names, views and infos. To refuse a
/// scenario, throw any std::exception: its text becomes the error message at the scenario's line.
class Setup {
 public:
  Setup(const SkybodySetup& raw, const SkybodyDeclare& declare) : raw_(raw), declare_(declare) {}

  /// This instance's path, such as `robots.quad.controllers.ctbr`.
  std::string instance() const { return raw_.instance; }
  double dt() const { return raw_.dt; }                     ///< physics step [s]
  int action_repeat() const { return raw_.action_repeat; }  ///< physics steps per action
  int horizon() const { return raw_.horizon; }              ///< steps per episode, 0: unlimited
  const double* gravity() const { return raw_.gravity; }    ///< 3 values, W [m/s^2]; nominal

  /// All robots, in the order of the scenario.
  View<RobotInfo> robots() const { return {raw_.robots, raw_.robot_count}; }
  /// All bodies, robot by robot: the base first, parents before children.
  View<BodyInfo> bodies() const { return {raw_.bodies, raw_.body_count}; }
  /// All links that belong to a body, robot by robot, in the order of the URDF.
  View<LinkInfo> links() const { return {raw_.links, raw_.link_count}; }
  /// All rotors, robot by robot, in the order of the rotors file.
  View<RotorInfo> rotors() const { return {raw_.rotors, raw_.rotor_count}; }
  /// All randomizable values, in the order of EnvView::param().
  View<EnvParamInfo> params() const { return {raw_.params, raw_.param_count}; }
  /// Tasks and randomizers: the chains of controllers, in robot order. Empty for others.
  View<ChainInfo> chains() const { return {raw_.chains, raw_.chain_count}; }
  /// Collision shapes of bodies, in body order, then obstacles; a shape's index is its id.
  /// Presence, pose and size of an obstacle in an environment: EnvView::param() from first_param
  /// on.
  View<ShapeInfo> shapes() const { return {raw_.shapes, raw_.shape_count}; }
  /// Shapes to draw, in body order: the visuals of each body, or the collision shapes of a body
  /// that has none, or a mesh of a format that is not read.
  View<VisualInfo> visuals() const { return {raw_.visuals, raw_.visual_count}; }
  /// Triangles of a visual of the kind SKYBODY_MESH. The file is read at the first call.
  /// @param visual  index in visuals()
  /// @throws std::runtime_error with the file and the reason if it has none
  const Triangles& visual_triangles(int visual) const;
  /// Triangles of an obstacle of the kind SKYBODY_HEIGHT_FIELD.
  /// @param obstacle  ShapeInfo::obstacle
  /// @throws std::runtime_error with the obstacle's name and the reason if it has none
  const Triangles& obstacle_triangles(int obstacle) const;

  /// The picture of a PNG or JPEG file, such as VisualInfo::texture or the value of a parameter
  /// that names files. Rows from the top, three bytes per pixel. The file is read at the first
  /// call.
  /// @throws std::runtime_error with the file and the reason if it has none
  const PictureInfo& picture(const std::string& file) const;

  /// Controllers: indices of the robots that this one serves: its own robot, or its team in the
  /// order of the scenario's list. Empty for others.
  View<std::int32_t> team() const { return {raw_.team, raw_.team_size}; }
  /// Controllers: index of the one robot that this one serves.
  /// @throws std::runtime_error if it serves a team of several; std::logic_error for other kinds
  int robot() const;
  /// Index of the robot called `name`; an empty name means the only robot.
  /// @throws std::runtime_error with the names of all robots
  int robot(const std::string& name) const;
  /// The rotors of one robot: world rotor indices [first, first + count).
  View<RotorInfo> rotors_of(int robot) const;
  /// A link of a robot. @throws std::runtime_error with the names of all links
  const LinkInfo& link(int robot, const std::string& name) const;
  /// The body of a robot that the joint `name` moves. @throws std::runtime_error with the names of
  /// all joints
  const BodyInfo& joint(int robot, const std::string& name) const;
  /// Its world body index.
  int index_of(const BodyInfo& body) const { return static_cast<int>(&body - raw_.bodies); }
  /// Index for EnvView::sensor() of the first value of a sensor's channel, and its size. Declares
  /// that the plugin reads it.
  /// @throws std::runtime_error with the names that exist
  int sensor(const std::string& instance, const std::string& channel, int* count = nullptr) const;
  /// Indices for EnvView::param() of the parameters that match `path`. A path may begin with
  /// `robot.` for every robot, and with `controllers.`, `sensors.`, `task.` for plugins. `[*]`
  /// matches all elements; `*` elsewhere matches any part of a name, or nothing: `kp*` also matches
  /// `kp`.
  /// @throws std::runtime_error if nothing matches
  std::vector<int> find_params(const std::string& path) const;

  /// Controllers: the command. `low` and `high` are the values of actions -1 and +1, one for each
  /// command value [the signal's units]. @throws std::logic_error if their sizes differ
  void input(Signal signal, const std::vector<double>& low, const std::vector<double>& high) const;
  /// Controllers that pass their command on to the next one: actions -1 and +1 have the meaning
  /// declared there. Loading fails if no later controller has a range.
  void input(Signal signal, int count) const;
  /// Controllers: the output of control(), `count` values. The last controller of a chain may give
  /// several signals to actuators: their values follow one another in the order of these calls.
  /// @param robot  the receiving robot, one of team(); -1: the first. The receiver is another
  ///        controller of the team, that robot's own chain, or its actuators
  void output(Signal signal, int count, int robot = -1) const;
  /// Controllers with output Signal::kWrench: the site at which values 6 i to 6 i + 5 act, for i =
  /// 0, 1, ...
  void site(const SkybodySite& site) const { declare_.site(declare_.host, &site); }
  /// Controllers with output Signal::kJoint: the drive of value i, for i = 0, 1, ... A coordinate
  /// has at most one drive.
  void joint(const SkybodyJointDrive& drive) const { declare_.joint(declare_.host, &drive); }
  /// Effects: declares an input that apply() adds to, by the methods of Held.
  void holds(HeldInput input) const { declare_.holds(declare_.host, static_cast<int>(input)); }
  /// Sensors and tasks: a part of the output or observation, in order: `count` values in `unit`,
  /// with bounds for the space (infinite if there are none).
  /// @param robot  robot whose observation it belongs to, -1: every robot
  /// @param doc    meaning of the values, for tables of columns
  void channel(const std::string& name, const std::string& unit, int count, double low, double high,
               int robot = -1, const std::string& doc = "") const;
  /// A channel for the critic only: an observed value that the policy does not see.
  void privileged_channel(const std::string& name, const std::string& unit, int count, double low,
                          double high, int robot = -1, const std::string& doc = "") const;
  /// Tasks: `count` values of the observation from `to` on repeat those from `from` on. Neither
  /// range may be privileged or contain a repeat. Where kLeavesRepeats<Real> a task need not write
  /// them.
  void repeat(int to, int from, int count) const {
    declare_.repeat(declare_.host, to, from, count);
  }
  /// Sensors: an image, which is written through EnvView::pixels(). It is not part of
  /// EnvView::sensor().
  /// @tparam T     std::uint8_t, std::uint16_t or float
  /// @param shape  one to three extents, such as {height, width, channels}; the last varies fastest
  /// @param low, high  bounds for the space; default: those of T
  template <class T>
  Image<T> image(const std::string& name, const std::vector<int>& shape, int robot = -1,
                 double low = kLeast<T>, double high = kGreatest<T>) const;
  /// Tasks: `count` values besides the observation (Evaluation::info), in order, for evaluations,
  /// such as a position error.
  void info(const std::string& name, const std::string& unit, int count,
            const std::string& doc = "") const;
  /// Controllers, sensors, effects: `count` info values, stored in words `first` to `first + count
  /// - 1` of the buffer. Their name becomes INSTANCE.NAME.
  void report(const std::string& name, const std::string& unit, int count, int first) const;
  /// Tasks: a part of the action, in robot order; -1 and +1 mean `low` and `high`. process() then
  /// computes the command from physical values. Without such calls the action is the chains'
  /// commands.
  /// @param robot  robot that the action belongs to
  void action(const std::string& name, const std::string& unit, int count, double low, double high,
              int robot) const;
  /// Tasks: commands are interpolated linearly over the physics steps of an action.
  void interpolate() const { declare_.interpolate(declare_.host); }
  /// Tasks: evaluate() writes a reward of each robot besides the team's.
  void robot_rewards() const { declare_.robot_rewards(declare_.host); }
  /// Sensors: sense() is called after every `physics_steps` physics steps. Controllers and effects:
  /// called before every such step; their output holds in between. Default 1. Tasks: period of
  /// process(); default: once per action.
  void period(int physics_steps) const { declare_.period(declare_.host, physics_steps); }
  /// `words` doubles of state besides State, for sizes known only in configure(); zero at a reset.
  void buffer(int words) const { declare_.buffer(declare_.host, words); }
  /// `count` values of scratch memory for a call (EnvView::scratch); not state.
  void scratch(int count) const { declare_.scratch(declare_.host, count); }
  /// Sensors written for plain double: `count` doubles in a row for a call, in the place of
  /// scratch() (EnvView::scratch_block).
  void scratch_block(int count) const { declare_.scratch_block(declare_.host, count); }
  /// `count` values of lasting memory (EnvView::memo); not state.
  void memo(int count) const { declare_.memo(declare_.host, count); }
  /// Effects: the output of apply() depends only on parameters: the scenario's and
  /// EnvView::param(). apply() is then called before the first physics step of an episode and when
  /// parameters may have changed, in place of a period. Its output holds in between.
  void steady() const { declare_.steady(declare_.host); }
  /// Requests EnvView::contact(), which costs time in large batches.
  void need_contacts() const { declare_.contacts(declare_.host); }
  /// Requests the contact of a world body with one partner, at the same cost.
  /// @param other  of kBody: a world body; of kObstacle: its index among the obstacles in shapes()
  /// @returns the index for EnvView::contact_pair()
  int contact_pair(int body, Partner partner, int other = 0) const {
    return declare_.contact_pair(declare_.host, body, static_cast<int>(partner), other);
  }
  /// Requests the force and moment that the inboard joint of a world body exerts on it. Costs one
  /// more evaluation of the dynamics in every physics step, lane by lane.
  /// @returns the index for EnvView::joint_reaction()
  int joint_reaction(int body) const { return declare_.joint_reaction(declare_.host, body); }
  /// Sensors: sense() may be skipped if its output has no reader before the next call, for at most
  /// SKYBODY_LONGEST_LEFT_OUT (1024) physics steps. Its result must not depend on whether earlier
  /// calls were skipped: a random walk draws the missing steps by Plugin::random_at().
  void only_when_read() const { declare_.only_when_read(declare_.host); }
  /// Effects: `count` words of the buffer from `first_word` on are `name` of a robot, which sensors
  /// may read. The name begins with the plugin's, such as `battery.charge`.
  void offers(const std::string& name, int robot, int first_word, int count = 1) const {
    declare_.offers(declare_.host, name.c_str(), robot, count, first_word);
  }
  /// Sensors: requests `count` values that an effect offers under that name for a robot. Without
  /// such an effect the scenario is refused.
  /// @returns the index of the first for EnvView::offered()
  int offered(const std::string& name, int robot, int count = 1) const {
    return declare_.offered(declare_.host, name.c_str(), robot, count);
  }
  /// Requests EnvView::body_before().
  void need_bodies_before() const { declare_.bodies_before(declare_.host); }
  /// Randomizers, and tasks for their own parameters: declares that parameter `param` of params()
  /// will be written. It is then clamped to its bounds after every draw. Two plugins that declare
  /// the same parameter are an error of the scenario.
  void writes(int param) const { declare_.writes(declare_.host, param); }
  /// Randomizers: requests a call before every physics step as well (Start::in_time), to draw
  /// parameters during the episode.
  void draws_in_time() const { declare_.draws_in_time(declare_.host); }
  /// Tasks: goal() returns the desired pose of the frame of world body `body` of `robot`. In order;
  /// at most once per robot. For a tool at the body's end, goal() returns the frame position that
  /// brings the tool to its target with the body's current rotation, and `point` is the tool's
  /// position.
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
