// Kinematic commands: the base's velocities, or its position and heading.
#include "controllers/common/position_box.h"

namespace skybody {
namespace {

class Velocity : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    control::require_floating_base(setup, setup.robot(), "`velocity` cannot drive");
    as_position_ = form_.value() == "position";
    velocity_ = max_velocity_.vec3();
    rate_ = max_rate_.vec3();
    if (as_position_) {
      box_.configure();
      box_.declare_position(setup);
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
      output.set(0, box_.clamped(input.vec3(0)));
      const SinCos<Real> half = sincos(0.5 * wrap_angle(input[3]));
      output.set(3, Quat<Real>{half.cos, Real(0.0), Real(0.0), half.sin});
      return;
    }
    output.set(0, control::clamp_symmetric(input.vec3(0), velocity_));
    output.set(3, control::clamp_symmetric(input.vec3(3), rate_));
  }

 private:
  TextParameter form_{this,
                      choice("form", "velocity", {"velocity", "position"},
                             "velocity: v and w in base axes; position: position and yaw, level")};
  RealsParameter max_velocity_{this,
                               reals("max_velocity", "m/s", {2.0, 2.0, 2.0}, at_least(1e-6),
                                     "velocities for action +1; commands are clamped to them")};
  RealsParameter max_rate_{this, reals("max_rate", "rad/s", {3.0, 3.0, 3.0}, at_least(1e-6),
                                       "rates for action +1; commands are clamped to them")};
  control::PositionBox box_{this, "form position: lower corner of the reachable box (W)",
                            "form position: upper corner of the reachable box (W)"};

  bool as_position_ = false;
  Vec3<double> velocity_{}, rate_{};
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Velocity, "velocity", "1.0.0",
               "Sets the base's velocity [m/s, rad/s], or its position and yaw, kinematically.");
