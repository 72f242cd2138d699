// The paper's hover task for one robot, or for a team that holds a formation.
#include <vector>

#include "tasks/common/flight.h"

namespace skybody {
namespace {

class Hover : public Task {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    flight::require_box(target_min_, target_max_);
    drawn_target_ = flight::announce_drawn(setup, target_);
    limits_ = limit_parameters_.limits();
    is_shaped_ = approach_reward_.value() != 0.0 || precision_reward_.value() != 0.0 ||
                 heading_reward_.value() != 0.0 || tilt_cost_.value() != 0.0 ||
                 failure_reward_.value() != 0.0;
    const int only = robot_.value().empty() ? -1 : setup.robot(robot_.value());
    const bool team = only < 0 && setup.robots().size() > 1;
    for (int r = 0; r < setup.robots().size(); ++r) {
      const RobotInfo& info = setup.robots()[r];
      const bool is_load = info.rotor_count == 0 && info.action_count == 0;
      if (only < 0 ? !(team && is_load) : r == only) add_robot(setup, r, team);
    }
    if (robots_.empty()) {
      throw std::runtime_error(
          "no robot has rotors or takes actions, so that none can hover: give one a controller, or "
          "take task `watch`");
    }
    set_offsets();
    if (team) setup.robot_rewards();
    setup.buffer(history_);
  }

  /// A target in the box, unless the scenario gives one.
  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>&, Start<Real>& start) const {
    if (drawn_target_ < 0) return;
    Random<Real> draw = random(env);
    for (int k = 0; k < 4; ++k) {
      const double low = k < 3 ? target_min_.value(k) : -target_yaw_.value();
      const double high = k < 3 ? target_max_.value(k) : target_yaw_.value();
      start.params.set(drawn_target_ + k, draw.uniform(Real(low), Real(high)));
    }
  }

  template <class Real>
  void reset(const EnvView<Real>&, State<Real>&, Values<Real> buffer) const {
    for (int k = 0; k < history_; ++k) buffer.set(k, Real(-1.0));
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out,
                Values<Real> buffer) const {
    remember(env, buffer);
    const Real target_yaw = target_(env, 3);
    Real reward(0.0);
    MaskOf<Real> failed(false);
    int at = 0, info = 0;
    for (const Robot& robot : robots_) {
      const BodyMotion<Real> body = env.body(robot.body);
      const Vec3<Real> error = target_of(robot, env) - body.position;
      const Real yaw_error = wrap_angle(target_yaw - yaw(body.rotation));
      out.observation.set(at, error);
      out.observation.set(at + 3, yaw_error);
      out.observation.set(at + 4, body.velocity);
      out.observation.set(at + 7, flight::canonical(body.rotation));
      out.observation.set(at + 11, body.angular_velocity);
      at += 14;
      for (int k = 0; k < 2 * robot.actions; ++k)
        out.observation.set(at++, buffer[robot.history + k]);
      if (out.wants_info()) {
        out.info.set(info++, norm(error));
        out.info.set(info++, abs(yaw_error));
        out.info.set(info++, flight::tilt(body.rotation));
        out.info.set(info++, norm(body.velocity));
      }
      const MaskOf<Real> robot_failed = flight::failed(body, limits_);
      Real own = flight::closeness(squared_norm(error) + yaw_error * yaw_error, kDistanceWeight) +
                 kRateReward * flight::closeness(squared_norm(body.angular_velocity), 1.0);
      if (is_shaped_) {
        own = own + shaping(norm(error), yaw_error) - tilt_cost(body.rotation) +
              select(robot_failed, Real(failure_reward_.value()), Real(0.0));
      }
      if (robots_.size() > 1) out.set_reward(robot.index, own);
      reward += own;
      failed = logical_or(failed, robot_failed);
    }
    if (robots_.size() > 1) reward = reward / static_cast<double>(robots_.size());
    out.set_reward(reward);
    out.terminate(failed);
  }

  template <class Real>
  void goal(const EnvView<Real>& env, const State<Real>&, Values<Real> goal) const {
    for (int i = 0; i < static_cast<int>(robots_.size()); ++i) {
      goal.set(4 * i, target_of(robots_[static_cast<std::size_t>(i)], env));
      goal.set(4 * i + 3, target_(env, 3));
    }
  }

 private:
  static constexpr double kDistanceWeight = 2.56;  // (1.6)^2 [1/m^2]
  static constexpr double kRateReward = 0.01;
  static constexpr double kApproachRange = 10.0;   // [m], about the largest distance at a start
  static constexpr double kPrecisionWeight = 5.0;  // 1 / 0.2 m
  static constexpr double kHeadingWeight = 4.0;    // (1 / 0.5 rad)^2
  static constexpr double kLeastCosine = 0.1;      // where the wall of the tilt ends, at 84 degrees

  /// What the paper's reward lacks for a learner: a slope far from the target, and one close by.
  template <class Real>
  SKYBODY_INLINE Real shaping(const Real& distance, const Real& yaw_error) const {
    const Real approach = max(Real(0.0), 1.0 - distance / kApproachRange);
    return approach_reward_.value() * approach +
           precision_reward_.value() * flight::closeness(distance, kPrecisionWeight) +
           heading_reward_.value() * flight::closeness(yaw_error * yaw_error, kHeadingWeight);
  }

  /// A wall before the tilt that ends an episode: its slope is felt where a failure is not yet.
  template <class Real>
  SKYBODY_INLINE Real tilt_cost(const Quat<Real>& rotation) const {
    return tilt_cost_.value() * (1.0 / max(tilt_cosine(rotation), Real(kLeastCosine)) - 1.0);
  }

  struct Robot {
    int index;
    int body;
    int first_action, actions;
    int history;          ///< within the buffer: this action, then the one before
    Vec3<double> offset;  ///< from the team's centre [m]
  };

  void add_robot(const Setup& setup, int index, bool team) {
    const RobotInfo& info = setup.robots()[index];
    const int actions = flight::action_count(info, "hover");
    const std::string prefix = team ? std::string(info.name) + "." : "";
    robots_.push_back({index,
                       info.first_body,
                       info.first_action,
                       actions,
                       history_,
                       {info.position[0], info.position[1], info.position[2]}});
    history_ += 2 * actions;
    setup.channel(prefix + "position_error", "m", 3, -kInfinity, kInfinity, index);
    setup.channel(prefix + "yaw_error", "rad", 1, -kPi, kPi, index);
    setup.channel(prefix + "velocity", "m/s", 3, -kInfinity, kInfinity, index);
    setup.channel(prefix + "attitude", "", 4, -1.0, 1.0, index);
    setup.channel(prefix + "angular_velocity", "rad/s", 3, -kInfinity, kInfinity, index);
    setup.channel(prefix + "actions", "", 2 * actions, -1.0, 1.0, index);
    setup.info(prefix + "position_error", "m", 1);
    setup.info(prefix + "yaw_error", "rad", 1);
    setup.info(prefix + "tilt", "rad", 1);
    setup.info(prefix + "speed", "m/s", 1);
    setup.goal(index, info.first_body);
  }

  /// Places in the team: `formation`, else where the scenario puts the robots, about their mean.
  void set_offsets() {
    const int count = static_cast<int>(robots_.size());
    if (formation_.count() != 0 && formation_.count() != 3 * count) {
      throw std::runtime_error("`formation` has " + std::to_string(formation_.count()) +
                               " values for " + std::to_string(count) +
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
    return target_.vec3(env) +
           Vec3<Real>{Real(robot.offset.x), Real(robot.offset.y), Real(robot.offset.z)};
  }

  /// Shifts the action of this step in; there is none at a reset.
  template <class Real>
  SKYBODY_INLINE void remember(const EnvView<Real>& env, Values<Real> buffer) const {
    const auto stepped = env.step() > Word<Real>(0);
    for (const Robot& robot : robots_) {
      for (int k = 0; k < robot.actions; ++k) {
        const int now = robot.history + k, before = now + robot.actions;
        buffer.set(before, select(stepped, buffer[now], buffer[before]));
        buffer.set(now, select(stepped, env.action(robot.first_action + k), buffer[now]));
      }
    }
  }

  TextParameter robot_{
      this,
      {.name = "robot",
       .doc = "who hovers; empty: all robots but loads (neither rotors nor actions), as a team"}};
  RealsParameter target_{
      this,
      {.name = "target",
       .unit = "m, rad",
       .values = {0.0, 0.0, 1.75, 0.0},
       .count = 4,
       .doc = "x, y, z (W), yaw; where the scenario gives none, one is drawn for "
              "each episode",
       .randomizable = true}};
  RealsParameter target_min_{this,
                             {.name = "target_min",
                              .unit = "m",
                              .values = {-5.0, -5.0, 0.5},
                              .doc = "lower corner of the box of drawn targets (W)"}};
  RealsParameter target_max_{this,
                             {.name = "target_max",
                              .unit = "m",
                              .values = {5.0, 5.0, 3.0},
                              .doc = "upper corner of the box of drawn targets (W)"}};
  RealParameter target_yaw_{this,
                            {.name = "target_yaw",
                             .unit = "rad",
                             .value = 0.72,
                             .min = 0.0,
                             .max = kPi,
                             .doc = "largest magnitude of a drawn heading"}};
  RealsParameter formation_{this,
                            {.name = "formation",
                             .unit = "m",
                             .count = -1,
                             .doc = "x, y, z of each robot from the target; none: as the scenario "
                                    "places them about their mean"}};
  flight::LimitParameters limit_parameters_{this};

  RealParameter approach_reward_{
      this,
      {.name = "approach_reward",
       .value = 0.0,
       .min = 0.0,
       .doc = "weight of max(0, 1 - |e| / 10 m) in the reward: a slope far from the target"}};
  RealParameter precision_reward_{
      this,
      {.name = "precision_reward",
       .value = 0.0,
       .min = 0.0,
       .doc = "weight of 1 / (1 + |e| / 0.2 m) in the reward: a slope up to the target"}};
  RealParameter heading_reward_{this,
                                {.name = "heading_reward",
                                 .value = 0.0,
                                 .min = 0.0,
                                 .doc = "weight of 1 / (1 + (e_psi / 0.5 rad)^2) in the reward: a "
                                        "slope far from the heading, too"}};
  RealParameter tilt_cost_{
      this,
      {.name = "tilt_cost",
       .value = 0.0,
       .min = 0.0,
       .doc =
           "weight of 1 / max(cos tilt, 0.1) - 1, taken off the reward: what dashing off costs"}};
  RealParameter failure_reward_{this,
                                {.name = "failure_reward",
                                 .value = 0.0,
                                 .max = 0.0,
                                 .doc = "added where an episode terminates"}};

  flight::Limits limits_{};
  int drawn_target_ = -1;   ///< first EnvParam of a target that is drawn; -1: the scenario's
  bool is_shaped_ = false;  ///< by anything that the paper's reward has not
  std::vector<Robot> robots_;
  int history_ = 0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Hover, "hover", "1.0.0", "Hold a target position and heading.");
