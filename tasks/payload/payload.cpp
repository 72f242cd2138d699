// The paper's payload task: bring what hangs below the robot to a point and keep it there.
#include <vector>

#include "tasks/common/flight.h"

namespace skybody {
namespace {

class Payload : public Task {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const int robot = setup.robot(robot_.value());
    const RobotInfo& info = setup.robots()[robot];
    const LinkInfo& link = setup.link(robot, link_.value());
    base_ = info.first_body;
    payload_ = link.body;
    center_ = {link.com[0], link.com[1], link.com[2]};
    if (payload_ == base_) {
      throw std::runtime_error("link `" + link_.value() + "` is fixed to the base of robot `" +
                               std::string(info.name) + "`: name one that hangs on a joint");
    }
    first_action_ = info.first_action;
    actions_ = flight::action_count(info, "payload");
    limits_ = limit_parameters_.limits();
    setup.channel("payload_error", "m", 3, -kInfinity, kInfinity, robot);
    setup.channel("payload_offset", "m", 3, -kInfinity, kInfinity, robot);
    setup.channel("attitude", "", 4, -1.0, 1.0, robot);
    setup.channel("velocity", "m/s", 3, -kInfinity, kInfinity, robot);
    setup.channel("angular_velocity", "rad/s", 3, -kInfinity, kInfinity, robot);
    setup.channel("payload_velocity", "m/s", 3, -kInfinity, kInfinity, robot);
    setup.channel("payload_angular_velocity", "rad/s", 3, -kInfinity, kInfinity, robot);
    setup.channel("action", "", actions_, -1.0, 1.0, robot);
    setup.info("payload_error", "m", 1);
    setup.info("tilt", "rad", 1);
    setup.info("speed", "m/s", 1);
    setup.goal(robot, payload_);
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out) const {
    const BodyMotion<Real> robot = env.body(base_), load = env.body(payload_);
    const Vec3<Real> arm = rotate(load.rotation, center<Real>());
    const Vec3<Real> position = load.position + arm;
    const Vec3<Real> velocity =
        load.velocity + rotate(load.rotation, cross(load.angular_velocity, center<Real>()));
    const Vec3<Real> error = position - target_.vec3(env);
    out.observation.set(0, error);
    out.observation.set(3, position - robot.position);
    out.observation.set(6, flight::canonical(robot.rotation));
    out.observation.set(10, robot.velocity);
    out.observation.set(13, robot.angular_velocity);
    out.observation.set(16, velocity);
    out.observation.set(19, load.angular_velocity);
    const auto stepped = env.step() > Word<Real>(0);
    for (int k = 0; k < actions_; ++k) {
      out.observation.set(22 + k, select(stepped, env.action(first_action_ + k), Real(-1.0)));
    }
    const Real turning = squared_norm(load.angular_velocity) + squared_norm(robot.angular_velocity);
    const Real reward = flight::closeness(squared_norm(error), kDistanceWeight) +
                        kRateReward * flight::closeness(turning, 1.0);
    const auto failed = flight::failed(robot, limits_);
    out.set_reward(select(failed, Real(failure_reward_.value()), reward));
    out.terminate(failed);
    out.info.set(0, norm(error));
    out.info.set(1, flight::tilt(robot.rotation));
    out.info.set(2, norm(robot.velocity));
  }

  /// Where the payload's frame belongs, turned as it is now.
  template <class Real>
  void goal(const EnvView<Real>& env, const State<Real>&, Values<Real> goal) const {
    const Quat<Real> rotation = env.body(payload_).rotation;
    goal.set(0, target_.vec3(env) - rotate(rotation, center<Real>()));
    goal.set(3, yaw(rotation));
  }

 private:
  static constexpr double kDistanceWeight = 1.6;  // [1/m^2]
  static constexpr double kRateReward = 0.1;

  template <class Real>
  SKYBODY_INLINE Vec3<Real> center() const {
    return {Real(center_.x), Real(center_.y), Real(center_.z)};
  }

  TextParameter robot_{this,
                       {.name = "robot", .doc = "who carries; may be left out for a single robot"}};
  TextParameter link_{this,
                      {.name = "payload_link", .value = "bob", .doc = "the link that is carried"}};
  RealsParameter target_{this,
                         {.name = "target",
                          .unit = "m",
                          .values = {0.0, 0.0, 0.5},
                          .doc = "where the payload's centre of mass should be (W)",
                          .randomizable = true}};
  RealParameter failure_reward_{this,
                                {.name = "failure_reward",
                                 .value = -50.0,
                                 .doc = "reward of the step in which the robot fails"}};
  flight::LimitParameters limit_parameters_{this};

  flight::Limits limits_{};
  int base_ = 0, payload_ = 0;
  int first_action_ = 0, actions_ = 0;
  Vec3<double> center_{};  ///< of mass, in the payload body's frame [m]
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Payload, "payload", "1.0.0", "Bring a hanging payload to a point.");
