// A vehicle holds its position while its arm brings a tool to a point.
#include <skybody/task_kit.h>

#include <algorithm>
#include <vector>

namespace skybody {
namespace {

using namespace task_kit;

class Reach : public Task {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const RobotInfo& info = robot_.configure(setup, "reach");
    const int robot = robot_.index();
    const LinkInfo& link = setup.link(robot, tool_.value());
    grip_ = {link.body, {link.position[0], link.position[1], link.position[2]}};
    home_ = {info.position[0], info.position[1], info.position[2]};
    heading_ =
        yaw(Quat<double>{info.rotation[0], info.rotation[1], info.rotation[2], info.rotation[3]});
    find_joints(setup, info);
    const int joints = static_cast<int>(joints_.size());
    const RobotParts part(setup, observation_, robot);
    tool_error_ = part("tool_error", "m", 3, "target of the tool - its position, W");
    tool_velocity_ = part("tool_velocity", "m/s", 3, "velocity of the tool, W");
    position_error_ =
        part("position_error", "m", 3, "the scenario's position - position of the base, W");
    yaw_error_ =
        part("yaw_error", "rad", 1, "the scenario's yaw - own yaw, wrapped to [-pi, pi]", kPi);
    motion_.declare(part);
    joint_positions_ = part("joint_positions", "", joints,
                            "positions of the arm's joints, from the base outwards [rad] or [m]");
    joint_rates_ = part("joint_rates", "", joints, "rates of the arm's joints [rad/s] or [m/s]");
    robot_.action.declare(part);
    tool_info_ = infos_.add(setup, "tool_error", "m", "distance of the tool from its target");
    position_info_ = infos_.add(setup, "position_error", "m",
                                "distance of the base from its position in the scenario");
    tilt_info_ = infos_.add(setup, "tilt", "rad", "tilt of the base, 0 .. pi");
    require_within(from_home(place_.vec3()), "the tool's `place`", limits_.bound());
    limits_.configure(setup, infos_);
    success_ = declare_success(setup, infos_, "the tool within `success_distance` of its target");
    setup.goal(robot, grip_.body, grip_.point);
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out) const {
    const BodyMotion<Real> base = env.body(robot_.body()), carrier = env.body(grip_.body);
    const Vec3<Real> tool_error =
        target(env) - carrier.position - rotate(carrier.rotation, grip_.lever<Real>());
    const Vec3<Real> error = home<Real>() - base.position;
    const Real yaw_error = wrap_angle(Real(heading_) - yaw(base.rotation));
    const Values<Real>& row = out.observation;
    tool_error_.set(row, tool_error);
    tool_velocity_.set(row, grip_.at(carrier).velocity);
    position_error_.set(row, error);
    yaw_error_.set(row, yaw_error);
    motion_.set(row, base);
    for (int k = 0; k < static_cast<int>(joints_.size()); ++k) {
      const Coordinate& joint = joints_[static_cast<std::size_t>(k)];
      joint_positions_.set(row, env.q(joint.q), k);
      joint_rates_.set(row, env.u(joint.u), k);
    }
    robot_.action.set(env, row);
    const PassedLimits<Real> passed = limits_.passed(base, yaw_error);
    const Real vehicle = squared_norm(error) + yaw_error * yaw_error;
    const Real reward =
        closeness(squared_norm(tool_error), kToolWeight) * closeness(vehicle, kVehicleWeight) +
        kRateReward * closeness(squared_norm(base.angular_velocity), 1.0);
    out.set_reward(select(passed.any(), Real(failure_reward_.value()), reward));
    Verdict<Real> verdict(out);
    limits_.judge(verdict, passed);
    if (out.wants_info()) {
      const Real distance = norm(tool_error);
      tool_info_.set(out.info, distance);
      position_info_.set(out.info, norm(error));
      tilt_info_.set(out.info, tilt(base.rotation));
      verdict.succeed(success_, distance < success_distance_.value());
    }
  }

  /// Goal pose of the body with the tool, in its present orientation; the vehicle's yaw.
  template <class Real>
  void goal(const EnvView<Real>& env, const State<Real>&, Values<Real> goal) const {
    goal.set(0, target(env) - rotate(env.body(grip_.body).rotation, grip_.lever<Real>()));
    goal.set(3, Real(heading_));
  }

 private:
  static constexpr double kToolWeight = 100.0;    // (1 / 0.1 m)^2
  static constexpr double kVehicleWeight = 2.56;  // as in `hover` [1/m^2]
  static constexpr double kRateReward = 0.01;

  /// World indices of a joint's coordinate and rate.
  struct Coordinate {
    int q, u;
  };

  /// The joints between the base and the tool, from the base on.
  void find_joints(const Setup& setup, const RobotInfo& robot) {
    for (int b = grip_.body; b != robot_.body(); b = setup.bodies()[b].parent) {
      const BodyInfo& body = setup.bodies()[b];
      if (body.joint != SKYBODY_PIN && body.joint != SKYBODY_SLIDER) {
        refuse("joint `", body.joint_name, "` of robot `", robot.name,
               "` is neither revolute nor prismatic: task `reach` needs an arm of such joints");
      }
      joints_.push_back({body.first_q, body.first_u});
    }
    if (joints_.empty()) {
      refuse("link `", tool_.value(), "` is fixed to the base of robot `", robot.name,
             "`: name one that an arm moves");
    }
    std::reverse(joints_.begin(), joints_.end());
  }

  /// The tool's position, W.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> target(const EnvView<Real>& env) const {
    return from_home(place_.vec3(env));
  }
  /// @param p  relative to the robot's initial position in the scenario, in its heading, level [m]
  template <class Real>
  SKYBODY_INLINE Vec3<Real> from_home(const Vec3<Real>& p) const {
    const double c = cos(heading_), s = sin(heading_);
    return home<Real>() + Vec3<Real>{c * p.x - s * p.y, s * p.x + c * p.y, p.z};
  }
  template <class Real>
  SKYBODY_INLINE Vec3<Real> home() const {
    return {Real(home_.x), Real(home_.y), Real(home_.z)};
  }
  OneRobot robot_{this};
  TextParameter tool_{this, word("tool", "gripper", "link whose frame is the tool")};
  RealsParameter place_{this,
                        randomizable(reals("place", "m", {0.0, 0.0, -0.4}, kAny,
                                           "target of the tool, relative to the robot's position "
                                           "in the scenario; axes: that heading, level"))};
  RealParameter failure_reward_{
      this, real("failure_reward", "", -50.0, kAny, "reward of the step in which the robot fails")};
  RealParameter success_distance_{
      this, real("success_distance", "m", 0.02, at_least(0.0),
                 "the tool has arrived if closer than this to its target (info `success`)")};
  FlightLimits limits_{this};

  ObservationParts observation_;
  InfoParts infos_;
  Part tool_error_, tool_velocity_, position_error_, yaw_error_, joint_positions_, joint_rates_;
  MotionParts motion_;
  Part tool_info_, position_info_, tilt_info_, success_;
  BodyPoint grip_;  ///< the tool
  std::vector<Coordinate> joints_;
  Vec3<double> home_{};   ///< the robot's position in the scenario, W [m]
  double heading_ = 0.0;  ///< the robot's yaw in the scenario [rad]
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Reach, "reach", "1.0.0",
               "Bring an arm's tool to a point while the vehicle holds its position.");
