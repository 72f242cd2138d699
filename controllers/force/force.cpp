// Rotor force in world axes and heading: the attitude with its z axis along the force, and the
// thrust. Chain `attitude`, then `ctbr`.
#include <vector>

#include "controllers/common/flatness.h"

namespace skybody {
namespace {

class Force : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    base_ = control::base_of(setup, robot);
    weight_ = control::total_mass(setup, robot) * control::gravity_of(setup);
    added_ = adds_weight_.value() ? weight_ : 0.0;
    takes_yaw_ = takes_yaw_parameter_.value();
    if (takes_yaw_ && yaw_.is_given()) {
      refuse(
          "`yaw` is given, but the command has a heading of its own: leave `yaw` out, or set "
          "`takes_yaw: false`");
    }
    const double up = adds_weight_.value() ? weight_ : 2.0 * weight_;
    const Vec3<double> most = control::force_limit(max_force_, {weight_, weight_, up});
    std::vector<double> low = {-most.x, -most.y, adds_weight_.value() ? -most.z : 0.0};
    std::vector<double> high = {most.x, most.y, most.z};
    if (takes_yaw_) {
      low.push_back(-kPi);
      high.push_back(kPi);
    }
    setup.input(Signal::kForce, low, high);
    setup.output(Signal::kAttitude, 5);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input,
               Values<Real> output) const {
    // Thrust is non-negative: a force that points down would turn the body over.
    const Vec3<Real> force{input[0], input[1], clamp(input[2] + added_, 0.0, kLargest)};
    const Real yaw = takes_yaw_ ? input[3] : Real(yaw_.value());
    output.set(0, max(Real(0.0), dot(force, body_z(env.body(base_).rotation))));
    output.set(1, control::flat_attitude(force, yaw).rotation);
  }

 private:
  BooleanParameter adds_weight_{
      this,
      boolean("adds_weight", false, "true: the command is added to the robot's nominal weight")};
  BooleanParameter takes_yaw_parameter_{
      this, boolean("takes_yaw", true, "the fourth value of the input is a heading")};
  RealParameter yaw_{
      this, real("yaw", "rad", 0.0, between(-kPi, kPi), "heading with `takes_yaw: false`")};
  RealsParameter max_force_{
      this, reals("max_force", "N", {0.0, 0.0, 0.0}, at_least(0.0),
                  "forces for action +1; 0: the weight, upwards twice the weight in total")};

  bool takes_yaw_ = true;
  int base_ = 0;
  double weight_ = 0.0, added_ = 0.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Force, "force", "1.0.0",
               "Controls the rotors' force in world axes [N] and yaw [rad]; output: attitude.");
