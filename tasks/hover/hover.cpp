// The paper's hover task for one robot, or for a team that holds a formation.
#include <skybody/task_kit.h>

#include <vector>

namespace skybody {
namespace {

using namespace task_kit;

class Hover : public Task {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    target_.configure(setup);
    target_.require_within(limits_.bound());
    is_shaped_ = shaping_.is_asked_for() || failure_reward_.value() != 0.0;
    const int only = robot_.value().empty() ? -1 : setup.robot(robot_.value());
    const bool team = only < 0 && setup.robots().size() > 1;
    for (int r = 0; r < setup.robots().size(); ++r) {
      const RobotInfo& info = setup.robots()[r];
      const bool is_load = info.rotor_count == 0 && info.action_count == 0;
      if (only < 0 ? !(team && is_load) : r == only) add_robot(setup, r, team);
    }
    if (robots_.empty()) {
      refuse(
          "no robot has rotors or takes actions, so that none can hover: give one a controller, or "
          "take task `watch`");
    }
    set_offsets();
    if (team) setup.robot_rewards();
    limits_.configure(setup, infos_);
    success_ =
        declare_success(setup, infos_, "every robot within `success_distance` of its position");
    setup.buffer(memory_.size());
  }

  /// Draws a target in the box, unless the scenario gives one.
  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>&, Start<Real>& start) const {
    target_.randomize(random(env), start);
  }

  template <class Real>
  void reset(const EnvView<Real>&, State<Real>&, Values<Real> buffer) const {
    for (const Robot& robot : robots_) {
      robot.past_actions.fill(buffer, [](int) { return Real(-1.0); });
    }
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out,
                Values<Real> buffer) const {
    const Real target_yaw = target_.yaw(env);
    Real reward(0.0), farthest(0.0);
    PassedLimits<Real> passed;
    for (const Robot& robot : robots_) {
      const BodyMotion<Real> body = env.body(robot.body);
      const Vec3<Real> error = target_of(robot, env) - body.position;
      const Real yaw_error = wrap_angle(target_yaw - yaw(body.rotation));
      remember(env, robot, buffer);
      observe(robot, body, error, yaw_error, buffer, out.observation);
      if (out.wants_info()) {
        const Real distance = norm(error);
        farthest = max(farthest, distance);
        robot.distance_info.set(out.info, distance);
        robot.yaw_info.set(out.info, abs(yaw_error));
        robot.tilt_info.set(out.info, tilt(body.rotation));
        robot.speed_info.set(out.info, norm(body.velocity));
      }
      const PassedLimits<Real> own_passed = limits_.passed(body);
      const Real own = reward_of(body, error, yaw_error, own_passed.any());
      if (robots_.size() > 1) out.set_reward(robot.index, own);
      reward += own;
      passed.add(own_passed);
    }
    if (robots_.size() > 1) reward = reward / static_cast<double>(robots_.size());
    out.set_reward(reward);
    Verdict<Real> verdict(out);
    limits_.judge(verdict, passed);
    verdict.succeed(success_, farthest < success_distance_.value());
  }

  template <class Real>
  void goal(const EnvView<Real>& env, const State<Real>&, Values<Real> goal) const {
    for (int i = 0; i < static_cast<int>(robots_.size()); ++i) {
      goal.set(4 * i, target_of(robots_[static_cast<std::size_t>(i)], env));
      goal.set(4 * i + 3, target_.yaw(env));
    }
  }

 private:
  static constexpr double kDistanceWeight = 2.56;  // (1.6)^2 [1/m^2]
  static constexpr double kRateReward = 0.01;

  struct Robot {
    int index;
    int body;
    int first_action;
    Vec3<double> offset;  ///< from the team's centre [m]
    Part position_error = {}, yaw_error = {}, actions = {};
    MotionParts motion = {};
    Part distance_info = {}, yaw_info = {}, tilt_info = {}, speed_info = {};
    History past_actions = {};  ///< this step's, then the previous one; empty: not observed
  };

  template <class Real>
  SKYBODY_INLINE void observe(const Robot& robot, const BodyMotion<Real>& body,
                              const Vec3<Real>& error, const Real& yaw_error,
                              const Values<Real>& buffer, const Values<Real>& row) const {
    robot.position_error.set(row, error);
    robot.yaw_error.set(row, yaw_error);
    robot.motion.set(row, body);
    robot.past_actions.observe(buffer, robot.actions, row);
  }

  /// One robot's reward: the paper's, plus optional shaping terms of the scenario.
  template <class Real>
  SKYBODY_INLINE Real reward_of(const BodyMotion<Real>& body, const Vec3<Real>& error,
                                const Real& yaw_error, const MaskOf<Real>& failed) const {
    const Real paper = closeness(squared_norm(error) + yaw_error * yaw_error, kDistanceWeight) +
                       kRateReward * closeness(squared_norm(body.angular_velocity), 1.0);
    if (!is_shaped_) return paper;
    return paper + shaping_.reward(norm(error), yaw_error) - shaping_.cost(body.rotation) +
           select(failed, Real(failure_reward_.value()), Real(0.0));
  }

  void add_robot(const Setup& setup, int index, bool team) {
    const RobotInfo& info = setup.robots()[index];
    const int actions = action_count(info, "hover");
    const std::string prefix = team ? std::string(info.name) + "." : "";
    const RobotParts part(setup, observation_, index, prefix);
    Robot robot{index,
                info.first_body,
                info.first_action,
                {info.position[0], info.position[1], info.position[2]}};
    robot.position_error = part("position_error", "m", 3, "target - position, W");
    robot.yaw_error =
        part("yaw_error", "rad", 1, "target yaw - own yaw, wrapped to [-pi, pi]", kPi);
    robot.motion.declare(part);
    if (past_actions_.value()) {
      robot.actions =
          part("actions", "", 2 * actions,
               "action of this step, then of the step before, in [-1, 1]; -1 at a reset", 1.0);
      robot.past_actions = History(memory_, 2, actions);
    }
    robot.distance_info =
        infos_.add(setup, prefix + "position_error", "m", "distance from the target");
    robot.yaw_info =
        infos_.add(setup, prefix + "yaw_error", "rad", "magnitude of the yaw error, 0 .. pi");
    robot.tilt_info = infos_.add(setup, prefix + "tilt", "rad",
                                 "angle between the body's z axis and the world's, 0 .. pi");
    robot.speed_info = infos_.add(setup, prefix + "speed", "m/s", "speed of the base's frame");
    robots_.push_back(robot);
    setup.goal(index, info.first_body);
  }

  /// Positions in the team: `formation`, or the scenario's positions relative to their mean.
  void set_offsets() {
    const int count = static_cast<int>(robots_.size());
    if (formation_.count() != 0 && formation_.count() != 3 * count) {
      refuse("`formation` has ", formation_.count(), " values for ", count,
             " robots: write x, y, z for each, or leave it out");
    }
    Vec3<double> mean{0.0, 0.0, 0.0};
    for (const Robot& r : robots_) mean += r.offset;
    mean = mean / static_cast<double>(count);
    for (int i = 0; i < count; ++i) {
      Vec3<double>& offset = robots_[static_cast<std::size_t>(i)].offset;
      offset -= mean;
      if (formation_.count() > 0) {
        offset = {formation_.value(3 * i), formation_.value(3 * i + 1),
                  formation_.value(3 * i + 2)};
      }
    }
  }

  template <class Real>
  SKYBODY_INLINE Vec3<Real> target_of(const Robot& robot, const EnvView<Real>& env) const {
    return target_.position(env) +
           Vec3<Real>{Real(robot.offset.x), Real(robot.offset.y), Real(robot.offset.z)};
  }

  /// Shifts in the action of this step; there is none at a reset.
  template <class Real>
  SKYBODY_INLINE void remember(const EnvView<Real>& env, const Robot& robot,
                               const Values<Real>& buffer) const {
    robot.past_actions.push(buffer, env.step() > Word<Real>(0),
                            [&](int k) { return env.action(robot.first_action + k); });
  }

  TextParameter robot_{this, word("robot", "",
                                  "name of the robot; empty: all robots except loads (neither "
                                  "rotors nor actions), as a team")};
  DrawnPose target_{this,
                    {.target = {0.0, 0.0, 1.75, 0.0},
                     .low = {-5.0, -5.0, 0.5},
                     .high = {5.0, 5.0, 3.0},
                     .doc = "x, y, z (W), yaw; drawn for each episode if the scenario gives none"},
                    0.72};
  RealsParameter formation_{this, list("formation", "m", {}, kAny,
                                       "x, y, z of each robot relative to the target; none: the "
                                       "scenario's positions relative to their mean")};
  BooleanParameter past_actions_{
      this,
      boolean("past_actions", true,
              "observe the last two actions; false: a policy that needs them must have memory")};
  FlightLimits limits_{this};
  GoalShaping shaping_{this};
  RealParameter failure_reward_{
      this, real("failure_reward", "", 0.0, at_most(0.0), "added if an episode terminates")};
  RealParameter success_distance_{
      this, real("success_distance", "m", 0.1, at_least(0.0),
                 "a robot has arrived if closer than this to its position (info `success`)")};

  ObservationParts observation_;
  InfoParts infos_;
  BufferPlan memory_;
  Part success_;
  bool is_shaped_ = false;  ///< whether there are terms beyond the paper's reward
  std::vector<Robot> robots_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Hover, "hover", "1.0.0", "Hold a target position and heading.");
