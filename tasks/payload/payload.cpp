// The paper's payload task: bring the load that hangs below the robot to a point and keep it there.
#include <skybody/task_kit.h>

namespace skybody {
namespace {

using namespace task_kit;

class Payload : public Task {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const RobotInfo& info = robot_.configure(setup, "payload");
    const int robot = robot_.index();
    const LinkInfo& link = setup.link(robot, link_.value());
    payload_ = {link.body, {link.com[0], link.com[1], link.com[2]}};
    if (payload_.body == robot_.body()) {
      refuse("link `", link_.value(), "` is fixed to the base of robot `", info.name,
             "`: name one that hangs on a joint");
    }
    require_within(target_, "target", limits_.bound());
    const RobotParts part(setup, observation_, robot);
    payload_error_ = part("payload_error", "m", 3, "payload - target, W");
    payload_offset_ = part("payload_offset", "m", 3, "payload - position of the base, W");
    attitude_ = part("attitude", "", 4, "quaternion w x y z, W from B, with w >= 0", 1.0);
    velocity_ = part("velocity", "m/s", 3, "velocity of the base's frame, W");
    angular_velocity_ = part("angular_velocity", "rad/s", 3, "angular velocity of the base, B");
    payload_velocity_ =
        part("payload_velocity", "m/s", 3, "velocity of the payload's centre of mass, W");
    payload_rates_ = part("payload_angular_velocity", "rad/s", 3,
                          "angular velocity of the payload, in its axes");
    robot_.action.declare(part);
    error_info_ =
        infos_.add(setup, "payload_error", "m", "distance of the payload from the target");
    tilt_info_ = infos_.add(setup, "tilt", "rad", "tilt of the base, 0 .. pi");
    speed_info_ = infos_.add(setup, "speed", "m/s", "speed of the base's frame");
    limits_.configure(setup, infos_);
    success_ =
        declare_success(setup, infos_, "the payload within `success_distance` of the target");
    setup.goal(robot, payload_.body);
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out) const {
    const BodyMotion<Real> robot = env.body(robot_.body());
    const BodyMotion<Real> load = payload_.at(env.body(payload_.body));
    const Vec3<Real> error = load.position - target_.vec3(env);
    const Values<Real>& row = out.observation;
    payload_error_.set(row, error);
    payload_offset_.set(row, load.position - robot.position);
    attitude_.set(row, canonical(robot.rotation));
    velocity_.set(row, robot.velocity);
    angular_velocity_.set(row, robot.angular_velocity);
    payload_velocity_.set(row, load.velocity);
    payload_rates_.set(row, load.angular_velocity);
    robot_.action.set(env, row);
    const Real turning = squared_norm(load.angular_velocity) + squared_norm(robot.angular_velocity);
    const Real reward =
        closeness(squared_norm(error), kDistanceWeight) + kRateReward * closeness(turning, 1.0);
    const PassedLimits<Real> passed = limits_.passed(robot);
    out.set_reward(
        select(passed.any(), Real(failure_reward_.value()), shaped(reward, error, robot)));
    Verdict<Real> verdict(out);
    limits_.judge(verdict, passed);
    if (out.wants_info()) {
      const Real distance = norm(error);
      error_info_.set(out.info, distance);
      tilt_info_.set(out.info, tilt(robot.rotation));
      speed_info_.set(out.info, norm(robot.velocity));
      verdict.succeed(success_, distance < success_distance_.value());
    }
  }

  /// Goal pose of the payload's frame, in its present orientation.
  template <class Real>
  void goal(const EnvView<Real>& env, const State<Real>&, Values<Real> goal) const {
    const Quat<Real> rotation = env.body(payload_.body).rotation;
    goal.set(0, target_.vec3(env) - rotate(rotation, payload_.lever<Real>()));
    goal.set(3, yaw(rotation));
  }

 private:
  static constexpr double kDistanceWeight = 1.6;  // [1/m^2]
  static constexpr double kRateReward = 0.1;

  /// The reward, with optional shaping terms of the scenario.
  template <class Real>
  SKYBODY_INLINE Real shaped(const Real& reward, const Vec3<Real>& error,
                             const BodyMotion<Real>& robot) const {
    if (!shaping_.is_asked_for()) return reward;
    return reward + shaping_.reward(norm(error), yaw(robot.rotation)) -
           shaping_.cost(robot.rotation);
  }

  OneRobot robot_{this};
  TextParameter link_{this, word("payload_link", "bob", "link of the payload")};
  RealsParameter target_{this, randomizable(reals("target", "m", {0.0, 0.0, 0.5}, kAny,
                                                  "target of the payload's centre of mass (W)"))};
  RealParameter failure_reward_{
      this, real("failure_reward", "", -50.0, kAny, "reward of the step in which the robot fails")};
  RealParameter success_distance_{
      this, real("success_distance", "m", 0.1, at_least(0.0),
                 "the payload has arrived if closer than this to the target (info `success`)")};
  FlightLimits limits_{this};
  GoalShaping shaping_{this};

  ObservationParts observation_;
  InfoParts infos_;
  Part payload_error_, payload_offset_, attitude_, velocity_, angular_velocity_, payload_velocity_,
      payload_rates_;
  Part error_info_, tilt_info_, speed_info_, success_;
  BodyPoint payload_;  ///< the payload's centre of mass
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Payload, "payload", "1.0.0", "Bring a hanging payload to a point.");
