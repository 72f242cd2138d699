// A vehicle holds its place while its arm brings a tool to a point.
#include <algorithm>
#include <vector>

#include "tasks/common/flight.h"

namespace skybody {
namespace {

class Reach : public Task {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const int robot = setup.robot(robot_.value());
    const RobotInfo& info = setup.robots()[robot];
    const LinkInfo& link = setup.link(robot, tool_.value());
    base_ = info.first_body;
    carrier_ = link.body;
    lever_ = {link.position[0], link.position[1], link.position[2]};
    home_ = {info.position[0], info.position[1], info.position[2]};
    heading_ =
        yaw(Quat<double>{info.rotation[0], info.rotation[1], info.rotation[2], info.rotation[3]});
    limits_ = limit_parameters_.limits();
    first_action_ = info.first_action;
    actions_ = flight::action_count(info, "reach");
    find_joints(setup, info);
    const int joints = static_cast<int>(joints_.size());
    setup.channel("tool_error", "m", 3, -kInfinity, kInfinity, robot);
    setup.channel("tool_velocity", "m/s", 3, -kInfinity, kInfinity, robot);
    setup.channel("position_error", "m", 3, -kInfinity, kInfinity, robot);
    setup.channel("yaw_error", "rad", 1, -kPi, kPi, robot);
    setup.channel("velocity", "m/s", 3, -kInfinity, kInfinity, robot);
    setup.channel("attitude", "", 4, -1.0, 1.0, robot);
    setup.channel("angular_velocity", "rad/s", 3, -kInfinity, kInfinity, robot);
    setup.channel("joint_positions", "", joints, -kInfinity, kInfinity, robot);
    setup.channel("joint_rates", "", joints, -kInfinity, kInfinity, robot);
    setup.channel("action", "", actions_, -1.0, 1.0, robot);
    setup.info("tool_error", "m", 1);
    setup.info("position_error", "m", 1);
    setup.info("tilt", "rad", 1);
    setup.goal(robot, carrier_, lever_);
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out) const {
    const BodyMotion<Real> base = env.body(base_), carrier = env.body(carrier_);
    const Vec3<Real> tool_error =
        target(env) - carrier.position - rotate(carrier.rotation, lever<Real>());
    const Vec3<Real> tool_velocity =
        carrier.velocity + rotate(carrier.rotation, cross(carrier.angular_velocity, lever<Real>()));
    const Vec3<Real> error = home<Real>() - base.position;
    const Real yaw_error = wrap_angle(Real(heading_) - yaw(base.rotation));
    out.observation.set(0, tool_error);
    out.observation.set(3, tool_velocity);
    out.observation.set(6, error);
    out.observation.set(9, yaw_error);
    out.observation.set(10, base.velocity);
    out.observation.set(13, flight::canonical(base.rotation));
    out.observation.set(17, base.angular_velocity);
    int at = 20;
    for (const Coordinate& joint : joints_) out.observation.set(at++, env.q(joint.q));
    for (const Coordinate& joint : joints_) out.observation.set(at++, env.u(joint.u));
    const auto stepped = env.step() > Word<Real>(0);
    for (int k = 0; k < actions_; ++k) {
      out.observation.set(at++, select(stepped, env.action(first_action_ + k), Real(-1.0)));
    }
    const auto failed = flight::failed(base, yaw_error, limits_);
    const Real vehicle = squared_norm(error) + yaw_error * yaw_error;
    const Real reward = flight::closeness(squared_norm(tool_error), kToolWeight) *
                            flight::closeness(vehicle, kVehicleWeight) +
                        kRateReward * flight::closeness(squared_norm(base.angular_velocity), 1.0);
    out.set_reward(select(failed, Real(failure_reward_.value()), reward));
    out.terminate(failed);
    out.info.set(0, norm(tool_error));
    out.info.set(1, norm(error));
    out.info.set(2, flight::tilt(base.rotation));
  }

  /// Where the frame of the body that has the tool belongs, turned as it is now; the vehicle's yaw.
  template <class Real>
  void goal(const EnvView<Real>& env, const State<Real>&, Values<Real> goal) const {
    goal.set(0, target(env) - rotate(env.body(carrier_).rotation, lever<Real>()));
    goal.set(3, Real(heading_));
  }

 private:
  static constexpr double kToolWeight = 100.0;    // (1 / 0.1 m)^2
  static constexpr double kVehicleWeight = 2.56;  // as of `hover` [1/m^2]
  static constexpr double kRateReward = 0.01;

  /// Places of a joint's coordinate and rate among the world's.
  struct Coordinate {
    int q, u;
  };

  /// The joints between the base and the tool, the one at the base first.
  void find_joints(const Setup& setup, const RobotInfo& robot) {
    for (int b = carrier_; b != base_; b = setup.bodies()[b].parent) {
      const BodyInfo& body = setup.bodies()[b];
      if (body.joint != SKYBODY_PIN && body.joint != SKYBODY_SLIDER) {
        throw std::runtime_error("joint `" + std::string(body.joint_name) + "` of robot `" +
                                 std::string(robot.name) +
                                 "` is neither revolute nor prismatic: task `reach` needs an arm "
                                 "of such joints");
      }
      joints_.push_back({body.first_q, body.first_u});
    }
    if (joints_.empty()) {
      throw std::runtime_error("link `" + tool_.value() + "` is fixed to the base of robot `" +
                               std::string(robot.name) + "`: name one that an arm moves");
    }
    std::reverse(joints_.begin(), joints_.end());
  }

  /// The tool's place, W.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> target(const EnvView<Real>& env) const {
    const Vec3<Real> p = place_.vec3(env);
    const double c = cos(heading_), s = sin(heading_);
    return home<Real>() + Vec3<Real>{c * p.x - s * p.y, s * p.x + c * p.y, p.z};
  }
  template <class Real>
  SKYBODY_INLINE Vec3<Real> home() const {
    return {Real(home_.x), Real(home_.y), Real(home_.z)};
  }
  template <class Real>
  SKYBODY_INLINE Vec3<Real> lever() const {
    return {Real(lever_.x), Real(lever_.y), Real(lever_.z)};
  }

  TextParameter robot_{this,
                       {.name = "robot", .doc = "who reaches; may be left out for a single robot"}};
  TextParameter tool_{
      this, {.name = "tool", .value = "gripper", .doc = "the link whose frame is the tool"}};
  RealsParameter place_{this,
                        {.name = "place",
                         .unit = "m",
                         .values = {0.0, 0.0, -0.4},
                         .doc = "where the tool should be, from the robot's place in the scenario; "
                                "axes: that heading, level",
                         .randomizable = true}};
  RealParameter failure_reward_{this,
                                {.name = "failure_reward",
                                 .value = -50.0,
                                 .doc = "reward of the step in which the robot fails"}};
  flight::LimitParameters limit_parameters_{this};

  flight::Limits limits_{};
  int base_ = 0, carrier_ = 0;
  int first_action_ = 0, actions_ = 0;
  std::vector<Coordinate> joints_;
  Vec3<double> lever_{};  ///< of the tool, in the frame of the body that has it [m]
  Vec3<double> home_{};   ///< the robot's place in the scenario, W [m]
  double heading_ = 0.0;  ///< and its yaw [rad]
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Reach, "reach", "1.0.0",
               "Bring an arm's tool to a point while the vehicle holds its place.");
