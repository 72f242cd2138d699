// Kinematic commands: the base's velocities, or its position and heading.
#include "controllers/common/robot.h"

namespace skybody {
namespace {

class Velocity : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const RobotInfo& robot = setup.robots()[setup.robot()];
    if (robot.fixed_base != 0) {
      throw std::runtime_error("robot `" + std::string(robot.name) +
                               "` has a fixed base, which `velocity` cannot drive: use a floating "
                               "base in its URDF");
    }
    as_position_ = form_.value() == "position";
    velocity_ = max_velocity_.vec3();
    rate_ = max_rate_.vec3();
    low_ = position_min_.vec3();
    high_ = position_max_.vec3();
    if (as_position_) {
      control::require_order("position_min[0]", low_.x, "position_max[0]", high_.x);
      control::require_order("position_min[1]", low_.y, "position_max[1]", high_.y);
      control::require_order("position_min[2]", low_.z, "position_max[2]", high_.z);
      setup.input(Signal::kPosition, {low_.x, low_.y, low_.z, -kPi},
                  {high_.x, high_.y, high_.z, kPi});
      setup.output(Signal::kPose, 7);
      return;
    }
    setup.input(Signal::kVelocity,
                {-velocity_.x, -velocity_.y, -velocity_.z, -rate_.x, -rate_.y, -rate_.z},
                {velocity_.x, velocity_.y, velocity_.z, rate_.x, rate_.y, rate_.z});
    setup.output(Signal::kVelocity, 6);
  }

  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> input,
               Values<Real> output) const {
    if (as_position_) {
      output.set(0, clamp(input[0], Real(low_.x), Real(high_.x)));
      output.set(1, clamp(input[1], Real(low_.y), Real(high_.y)));
      output.set(2, clamp(input[2], Real(low_.z), Real(high_.z)));
      const SinCos<Real> half = sincos(0.5 * wrap_angle(input[3]));
      output.set(3, Quat<Real>{half.cos, Real(0.0), Real(0.0), half.sin});
      return;
    }
    output.set(0, control::clamp_symmetric(input.vec3(0), velocity_));
    output.set(3, control::clamp_symmetric(input.vec3(3), rate_));
  }

 private:
  TextParameter form_{this,
                      {.name = "form",
                       .value = "velocity",
                       .choices = {"velocity", "position"},
                       .doc = "velocity: v and w in base axes; position: position and yaw, level"}};
  RealsParameter max_velocity_{this,
                               {.name = "max_velocity",
                                .unit = "m/s",
                                .values = {2.0, 2.0, 2.0},
                                .min = 1e-6,
                                .doc = "velocities for action +1; commands are clamped to them"}};
  RealsParameter max_rate_{this,
                           {.name = "max_rate",
                            .unit = "rad/s",
                            .values = {3.0, 3.0, 3.0},
                            .min = 1e-6,
                            .doc = "rates for action +1; commands are clamped to them"}};
  RealsParameter position_min_{this,
                               {.name = "position_min",
                                .unit = "m",
                                .values = {-5.0, -5.0, 0.5},
                                .doc = "form position: lower corner of the reachable box (W)"}};
  RealsParameter position_max_{this,
                               {.name = "position_max",
                                .unit = "m",
                                .values = {5.0, 5.0, 3.0},
                                .doc = "form position: upper corner of the reachable box (W)"}};

  bool as_position_ = false;
  Vec3<double> velocity_{}, rate_{}, low_{}, high_{};
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Velocity, "velocity", "1.0.0",
               "Sets the base's velocity [m/s, rad/s], or its position and yaw, kinematically.");
